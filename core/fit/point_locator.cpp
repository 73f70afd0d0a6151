// SPDX-License-Identifier: Apache-2.0
#include "point_locator.h"

#include <algorithm>

#include "../field/piece.h"

namespace octet {
namespace {

/// Barycentric coordinates of a point in a tetrahedron that holds it, else false.
bool weightsIn(const std::array<Vec3, 4>& corners, const Vec3& point, double* weights) {
  const Barycentric lambda(corners);
  if (!lambda.finite()) return false;
  for (int i = 0; i < 4; ++i) {
    weights[i] = lambda.gradients[i].dot(point - lambda.origin) + (i == 0 ? 1 : 0);
    if (weights[i] < -kSharedFacetTolerance) return false;
  }
  return true;
}

}  // namespace

PointLocator::PointLocator(std::shared_ptr<const Complex> complex, const Array<Vec3>& positions)
    : complex_(std::move(complex)), positions_(positions) {
  bins_ = BoxBins(complex_->cellCount(), [&](Index cell) {
    Box box;
    for (int i = 0; i < complex_->cellVertexCount(cell); ++i) {
      box.extend(positions_[complex_->cellVertex(cell, i)]);
    }
    return box;
  });
}

bool PointLocator::locate(const Vec3& point, VertexWeights* result) const {
  return bins_.visitAt(point, [&](Index cell) { return locateInCell(cell, point, result); });
}

bool PointLocator::locateInCell(Index cell, const Vec3& point, VertexWeights* result) const {
  const int n = complex_->cellVertexCount(cell);
  std::array<Vec3, 4> corners;
  double weights[4];
  result->count = n;
  for (int i = 0; i < n; ++i) result->vertices[i] = complex_->cellVertex(cell, i);
  if (n == 4) {
    for (int i = 0; i < 4; ++i) corners[i] = positions_[result->vertices[i]];
    if (!weightsIn(corners, point, weights)) return false;
    std::copy(weights, weights + 4, result->weights.begin());
    return true;
  }
  corners[3].setZero();
  for (int i = 0; i < n; ++i) corners[3] += positions_[result->vertices[i]] / 6;
  for (const auto& facet : Octahedron::facets) {
    for (int k = 0; k < 3; ++k) corners[k] = positions_[result->vertices[facet[k]]];
    if (!weightsIn(corners, point, weights)) continue;
    result->weights.fill(weights[3] / 6);
    for (int k = 0; k < 3; ++k) result->weights[facet[k]] += weights[k];
    return true;
  }
  return false;
}

}  // namespace octet
