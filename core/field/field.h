// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>

#include "limit.h"
#include "piece_source.h"
#include "scheme_subdivision.h"

namespace octet {

/// How a field is rebuilt from coefficients (SCHEME.md section 9).
enum class Reconstruction : std::uint8_t {
  Limit,    ///< limit vectors at vertices, linear in between: continuous, second order
  Whitney,  ///< Whitney forms on the finest level: first order, exact integrals
};

/// @brief A field of C components that can be sampled at arbitrary points. Cheap to copy; const
/// members are thread safe.
template <int C>
class Field {
 public:
  using Value = typename Piece<C>::Value;

  explicit Field(std::shared_ptr<const PieceSource<C>> source);

  const PieceSource<C>& source() const { return *state_->source; }
  /// Box of the domain, world units.
  const Box& bounds() const { return state_->bounds; }

  /// Value at a point in world units; false outside the domain, `value` is then untouched.
  bool sample(const Vec3& point, Value* value) const;

  /// Values at many points, in parallel; `inside[i]` is 1 where points[i] lies in the domain, and
  /// values[i] is 0 elsewhere.
  /// @throws Cancelled
  void sample(const Vec3* points, std::size_t count, Value* values, std::uint8_t* inside,
              const Context& context = {}) const;

 private:
  struct State {
    std::shared_ptr<const PieceSource<C>> source;
    Box bounds;
    std::once_flag once;
    BoxBins bins;  // over cells, made when first needed
  };
  std::shared_ptr<State> state_;
};

using ScalarField = Field<1>;
using VectorField = Field<3>;

/// The field of a form's coefficients on a refiner's finest level: of a 0-form its value, of a
/// 1-form its vector, of a 2-form its flux density, of a 3-form its density.
/// @param limit  made from the same refiner; a Whitney field uses it for nothing and keeps the
///               finest level's own positions.
template <int K>
Field<kComponents<K>> makeField(const Refiner& refiner, const Limit& limit, Cochain<K> form,
                                BoundaryMode mode,
                                Reconstruction reconstruction = Reconstruction::Limit,
                                const Context& context = {});

/// The field of a form's coefficients on the control mesh. A rule without limits is rebuilt by
/// Whitney forms, whatever is asked for.
template <int K>
Field<kComponents<K>> makeField(const Subdivision& subdivision, const Cochain<K>& control,
                                BoundaryMode mode,
                                Reconstruction reconstruction = Reconstruction::Limit,
                                const Context& context = {});

}  // namespace octet
