// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../refine/refiner.h"
#include "../refine/sparse_row.h"
#include "limit_masks.h"
#include "star_limits.h"

namespace octet {

/// @brief Limits at the vertices of a refiner's finest level (SCHEME.md sections 5 and 9): one
/// value or vector per vertex, to be interpolated linearly. Second-order accurate, while piecewise
/// Whitney forms are first-order and jump.
///
/// Values and positions: exact masks at regular vertices, at irregular stars inside and on the
/// boundary (that of the wall's surface and the cubic B-spline's); where stars disturb each other,
/// on a control mesh and beside its edges, the smoothed value that agrees with the regular mask to
/// fourth order.
/// Vectors: exact masks at regular vertices, mapped to space by the positions' own mask so that
/// constants are exact on deformed lattices too; elsewhere the least-squares linear field through
/// the coefficients of the star. On walls whose coefficients are all 0 vectors are tangential
/// (2-forms) or normal (1-forms), exactly.
///
/// Built once per refiner, applied to any number of forms; const members are thread safe. The
/// refiner must outlive it.
class Limit {
 public:
  explicit Limit(const Refiner& refiner, const Context& context = {});

  /// Limit positions of the vertices, world units.
  const Array<Vec3>& positions() const { return positions_; }

  /// Limit values of a 0-form on the finest level.
  Array<double> values(const Cochain<0>& form, const Context& context = {}) const;
  /// Limit vectors of a 1-form (per world unit of length).
  Array<Vec3> vectors(const Cochain<1>& form, BoundaryMode mode, const Context& context = {}) const;
  /// Limit flux density of a 2-form (per world unit of area).
  Array<Vec3> vectors(const Cochain<2>& form, BoundaryMode mode, const Context& context = {}) const;
  /// Limit density of a 3-form (per world unit of volume).
  Array<double> densities(const Cochain<3>& form, const Context& context = {}) const;

  /// How the limit vector at one vertex depends on the finest coefficients of a K-form, K = 1 or 2:
  /// its x, y and z as functionals. @param onClosedWall  what closedWalls() says of the vertex
  template <int K>
  std::array<SparseRow, 3> vectorRows(Index vertex, bool onClosedWall) const;
  /// 1 for every vertex at which vectors() keeps to a wall whose coefficients are all 0.
  template <int K>
  std::vector<std::uint8_t> closedWalls(const Cochain<K>& form, BoundaryMode mode) const;

 private:
  template <typename At>
  double valueAt(Index vertex, const At& at) const;
  template <int K>
  Array<Vec3> vectorsOf(const Cochain<K>& form, BoundaryMode mode, const Context& context) const;
  template <int K>
  Vec3 regularVector(Index site, const double* form) const;
  template <int K>
  Vec3 fittedVector(Index vertex, const double* form) const;
  template <int K>
  bool onClosedWall(Index boundaryRow, const double* form) const;
  template <int K, typename Add>
  Eigen::Matrix3d addRegular(Index site, const Add& add) const;
  template <int K, typename Begin, typename Add>
  bool addStar(Index vertex, const Begin& begin, const Add& add) const;
  Eigen::Matrix3d tangentialProjection(Index boundaryRow) const;
  void prepareWalls();

  const Refiner& refiner_;
  const Complex& c_;
  const LatticeSites& sites_;
  const Array<Vec3>& coefficientPositions_;  // of the finest level, to which coefficients refer
  LimitMasks masks_;
  StarLimits starLimits_;
  Array<Vec3> positions_;
  std::vector<Eigen::Matrix3d> walls_;  // per boundary row: projection along the wall
};

}  // namespace octet
