// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../forms/cochain.h"
#include "../rules/octahedron_split.h"
#include "piece_source.h"

namespace octet {

/// Coefficients of a form on one cell, along the cell's own orientations.
template <int K, typename Shape>
LocalForm<K, Shape> localForm(const Complex& c, Index cell, const Cochain<K>& form) {
  LocalForm<K, Shape> local;
  for (int k = 0; k < kLocalCount<K, Shape>; ++k) {
    if constexpr (K == 0) local[k] = form[c.cellVertex(cell, k)];
    if constexpr (K == 1)
      local[k] = form.at(c.cellEdge(cell, Shape::edges[k][0], Shape::edges[k][1]));
    if constexpr (K == 2) local[k] = form.at(c.cellFacet(cell, k));
    if constexpr (K == 3) local[k] = form[cell];
  }
  return local;
}

template <typename Shape>
double volume6(const std::array<Vec3, Shape::kVertices>& p) {
  Vec3 centroid = Vec3::Zero();
  for (const Vec3& x : p) centroid += x / static_cast<double>(Shape::kVertices);
  double sum = 0;
  for (const auto& f : Shape::facets) {
    sum += (p[f[0]] - centroid).dot((p[f[1]] - centroid).cross(p[f[2]] - centroid));
  }
  return sum;
}

/// The Whitney form in a tetrahedron (thesis 3.2.2), by its values at the corners.
/// @param p      corners in the world
/// @param shape  the same up to a translation, with all digits of their differences
template <int K>
Piece<kComponents<K>> whitneyPiece(const std::array<Vec3, 4>& p, const std::array<Vec3, 4>& shape,
                                   const LocalForm<K, Tetrahedron>& w) {
  Piece<kComponents<K>> piece;
  piece.points = p;
  const Barycentric lambda(shape);
  for (int a = 0; a < 4; ++a) {
    auto& value = piece.values[a];
    value.setZero();
    if constexpr (K == 0) value[0] = w[a];
    if constexpr (K == 1) {
      for (int b = 0; b < 4; ++b) {
        if (b == a) continue;
        const int e = kCellTables<Tetrahedron>.edgeBetween[a][b];
        value += (a < b ? w[e] : -w[e]) * lambda.gradients[b];
      }
    }
    if constexpr (K == 2) {
      for (int f = 0; f < 4; ++f) {
        const auto& t = Tetrahedron::facets[f];
        for (int s = 0; s < 3; ++s) {
          if (t[s] != a) continue;
          value +=
              2 * w[f] * lambda.gradients[t[(s + 1) % 3]].cross(lambda.gradients[t[(s + 2) % 3]]);
        }
      }
    }
    if constexpr (K == 3) value[0] = w[0] / std::abs(volume6<Tetrahedron>(shape) / 6);
  }
  return piece;
}

}  // namespace octet
