// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <mutex>
#include <optional>

#include "../refine/subdivision.h"
#include "limit.h"

namespace octet {

/// @brief Subdivision by the scheme (SCHEME.md sections 3 to 9): a Refiner and its Limit.
class SchemeSubdivision : public Subdivision {
 public:
  /// @throws InputError as Refiner
  explicit SchemeSubdivision(const ControlMesh& mesh, const RefinerOptions& options = {},
                             const Context& context = {});

  const Refiner& refiner() const { return refiner_; }
  /// The refiner's limit, made when it is first needed.
  const Limit& limit(const Context& context = {}) const;

  int levels() const override { return refiner_.levels(); }
  std::shared_ptr<const Complex> complex(int level) const override;
  const Array<Vec3>& positions(int level) const override { return refiner_.positions(level); }
  double zeta() const override { return refiner_.zeta(); }

  Cochain<0> refine(const Cochain<0>& control, BoundaryMode mode,
                    const Context& context) const override;
  Cochain<1> refine(const Cochain<1>& control, BoundaryMode mode,
                    const Context& context) const override;
  Cochain<2> refine(const Cochain<2>& control, BoundaryMode mode,
                    const Context& context) const override;
  Cochain<3> refine(const Cochain<3>& control, BoundaryMode mode,
                    const Context& context) const override;

  const Array<Vec3>& limitPositions(const Context& context) const override {
    return limit(context).positions();
  }
  Array<double> limitValues(const Cochain<0>& control, BoundaryMode mode,
                            const Context& context) const override;
  Array<Vec3> limitVectors(const Cochain<1>& control, BoundaryMode mode,
                           const Context& context) const override;
  Array<Vec3> limitVectors(const Cochain<2>& control, BoundaryMode mode,
                           const Context& context) const override;
  Array<double> limitDensities(const Cochain<3>& control, BoundaryMode mode,
                               const Context& context) const override;

 private:
  Refiner refiner_;
  mutable std::once_flag once_;
  mutable std::optional<Limit> limit_;
};

/// Subdivides a mesh: by which rule is for a caller to choose.
using Subdivide = std::function<std::unique_ptr<Subdivision>(
    const ControlMesh& mesh, const RefinerOptions& options, const Context& context)>;

/// Makes a SchemeSubdivision.
std::unique_ptr<Subdivision> subdivideByScheme(const ControlMesh& mesh,
                                               const RefinerOptions& options,
                                               const Context& context);

}  // namespace octet
