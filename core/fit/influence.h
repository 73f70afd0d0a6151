// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../field/limit.h"
#include "../refine/step_adjoint.h"
#include "point_locator.h"

namespace octet {

/// Functionals over the control coefficients of a form: its limit vectors at points.
struct InfluenceRows {
  std::vector<SparseRow> rows;       ///< 3 i + axis for point i; empty outside the domain
  std::vector<std::uint8_t> inside;  ///< per point
};

/// @brief How the limit field at given points depends on the control coefficients of a K-form,
/// K = 1 or 2: the adjoint of refinement, limit masks and interpolation, exact to rounding, not by
/// finite differences.
///
/// Built once per refiner and mode; const members are thread safe. Refiner and limit must outlive
/// it.
template <int K>
class Influence {
 public:
  /// @param zero  control simplices whose coefficient is always 0, one flag each: what they make of
  ///              walls decides where the limit keeps to them (Limit::vectors)
  Influence(const Refiner& refiner, const Limit& limit, BoundaryMode mode,
            const std::vector<std::uint8_t>& zero, const Context& context = {});

  InfluenceRows at(const std::vector<Vec3>& points, const Context& context = {}) const;

  const PointLocator& locator() const { return locator_; }

 private:
  std::vector<SparseRow> vertexRows(const std::vector<Index>& vertices,
                                    const Context& context) const;

  const Limit& limit_;
  Index controlCount_;
  PointLocator locator_;
  RefinementAdjoint<K> adjoint_;
  std::vector<std::uint8_t> closed_;  // per finest vertex
};

}  // namespace octet
