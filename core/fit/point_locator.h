// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "../geometry/box_bins.h"
#include "../topology/complex.h"

namespace octet {

/// A point as an affine combination of the vertices of a cell.
struct VertexWeights {
  int count = 0;
  std::array<Index, 6> vertices;
  std::array<double, 6> weights;
};

/// @brief Finds where points lie in the pieces that a VertexField is linear on: tetrahedra, and the
/// eight around an octahedron's centroid. Picks the piece that Field::sample picks. Thread safe.
class PointLocator {
 public:
  PointLocator(std::shared_ptr<const Complex> complex, const Array<Vec3>& positions);

  /// @return false outside the domain
  bool locate(const Vec3& point, VertexWeights* result) const;
  const Box& bounds() const { return bins_.bounds(); }

 private:
  bool locateInCell(Index cell, const Vec3& point, VertexWeights* result) const;

  std::shared_ptr<const Complex> complex_;
  const Array<Vec3>& positions_;
  BoxBins bins_;
};

}  // namespace octet
