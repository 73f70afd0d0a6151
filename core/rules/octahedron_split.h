// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "local_linear.h"

namespace octet {

/// Coefficients of a form on one cell: vertices; edges, lower to higher local vertex; outward
/// facets; or the cell's mass.
template <int K, typename Shape>
inline constexpr int kLocalCount = K == 0   ? Shape::kVertices
                                   : K == 1 ? Shape::kEdges
                                   : K == 2 ? Shape::kFacets
                                            : 1;
template <int K, typename Shape>
using LocalForm = std::array<double, kLocalCount<K, Shape>>;

/// Linear subdivision of a form on an octahedron, as matrices to its children's coefficients.
template <int K>
class OctahedronSplit {
 public:
  explicit OctahedronSplit(const LinearRules& rules) {
    const auto& split = SplitTables<Octahedron>::get();
    for (int k = 0; k < 8; ++k) fill<Tetrahedron>(rules, split.tets[k], &tets_[k], 1.0 / 32);
    for (int k = 0; k < 6; ++k) fill<Octahedron>(rules, split.octs[k], &octs_[k], 1.0 / 8);
  }

  LocalForm<K, Tetrahedron> tet(int k, const LocalForm<K, Octahedron>& w) const {
    return multiply<Tetrahedron>(tets_[k], w);
  }
  LocalForm<K, Octahedron> oct(int k, const LocalForm<K, Octahedron>& w) const {
    return multiply<Octahedron>(octs_[k], w);
  }

 private:
  template <typename Shape>
  using Matrix = std::array<LocalForm<K, Octahedron>, kLocalCount<K, Shape>>;

  template <typename Shape>
  static void fill(const LinearRules& rules, const std::uint8_t* child, Matrix<Shape>* matrix,
                   double massShare) {
    const LocalLinear<Octahedron> linear(rules);
    for (int k = 0; k < kLocalCount<K, Shape>; ++k) {
      auto& row = (*matrix)[k];
      row.fill(0);
      if constexpr (K == 0) {
        const int label = child[k];
        if (label == kCentreLabel) {
          row.fill(1.0 / 6);
        } else if (label < 6) {
          row[label] = 1;
        } else {
          for (const int i : Octahedron::edges[label - 6]) row[i] = 0.5;
        }
      } else if constexpr (K == 1) {
        row = linear.edge(child[Shape::edges[k][0]], child[Shape::edges[k][1]]);
      } else if constexpr (K == 2) {
        const auto& t = Shape::facets[k];
        row = linear.facet(child[t[0]], child[t[1]], child[t[2]]);
      } else {
        row[0] = massShare;
      }
    }
  }

  template <typename Shape>
  static LocalForm<K, Shape> multiply(const Matrix<Shape>& matrix,
                                      const LocalForm<K, Octahedron>& w) {
    LocalForm<K, Shape> result;
    for (std::size_t k = 0; k < result.size(); ++k) {
      result[k] = 0;
      for (std::size_t j = 0; j < w.size(); ++j) result[k] += matrix[k][j] * w[j];
    }
    return result;
  }

  std::array<Matrix<Tetrahedron>, 8> tets_;
  std::array<Matrix<Octahedron>, 6> octs_;
};

}  // namespace octet
