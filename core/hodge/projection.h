// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "../base/context.h"
#include "../forms/cochain.h"

namespace octet {

/// What a projection does with coefficients on the boundary.
enum class BoundaryRule : std::uint8_t {
  Free,  ///< changes them like any other
  Keep,  ///< leaves them as they are
  Zero,  ///< makes them 0: nothing through the walls (2-forms), nothing along them (1-forms)
  /// Makes them 0 on the walls of cavities, as around an obstacle in a domain with open sides.
  ZeroInside,
};

/// @brief The closed form nearest to a given one, d w' = 0, in the norm of the mass matrix: among
/// all fields without divergence (K = 2) or curl (K = 1) the one that differs least in energy
/// (SCHEME.md section 9). Closed on the control mesh is closed at every level.
///
/// Made once per mesh, applied to any number of forms. Const members are thread safe. Uses a direct
/// sparse solver: for control meshes, up to some ten thousand cells.
template <int K>
class ClosedProjection {
  static_assert(K == 1 || K == 2, "0-forms and 3-forms need no projection");

 public:
  /// @param fixed  per simplex, 1 where coefficients are prescribed; empty: nowhere
  ClosedProjection(const Complex& complex, const Array<Vec3>& positions,
                   const std::vector<std::uint8_t>& fixed, const Context& context = {});
  ~ClosedProjection();
  ClosedProjection(ClosedProjection&&) noexcept;

  /// @param fixedToZero  fixed coefficients become 0 instead of staying what they are
  /// @throws InputError when no closed form has these fixed coefficients, as when a net flux enters
  /// through a boundary that is kept.
  Cochain<K> apply(const Cochain<K>& form, bool fixedToZero = false,
                   const Context& context = {}) const;

 private:
  struct System;
  std::unique_ptr<const System> system_;
};

/// 1 for each k-simplex on the boundary.
template <int K>
std::vector<std::uint8_t> onBoundary(const Complex& complex);

/// 1 for each k-simplex whose coefficient a rule prescribes; empty: none.
/// @param positions  tell the walls of cavities from the outer boundary
template <int K>
std::vector<std::uint8_t> fixedBy(BoundaryRule rule, const Complex& complex,
                                  const Array<Vec3>& positions);

/// Whether a rule makes the coefficients 0 that it prescribes.
inline bool fixesToZero(BoundaryRule rule) {
  return rule == BoundaryRule::Zero || rule == BoundaryRule::ZeroInside;
}

/// ClosedProjection for one form. @throws InputError as there
template <int K>
Cochain<K> nearestClosed(const Complex& complex, const Array<Vec3>& positions,
                         const Cochain<K>& form, BoundaryRule rule = BoundaryRule::Free,
                         const Context& context = {});

}  // namespace octet
