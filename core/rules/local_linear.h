// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>

#include "linear_rules.h"
#include "split_tables.h"

namespace octet {

/// Numbering of the fine edges in the closure of a split cell: halves of its edges, the edges that
/// cut off corners of its facets, and the spokes of an octahedron.
template <typename Shape>
struct FineEdges {
  static constexpr int kHalves = 2 * Shape::kEdges;
  static constexpr int kCuts = 3 * Shape::kFacets;
  static constexpr int kSpokes = Shape::kVertices == 6 ? 12 : 0;
  static constexpr int kCount = kHalves + kCuts + kSpokes;

  /// Half of local edge k at its lower (0) or higher (1) local vertex, along the edge.
  static constexpr int half(int k, int end) { return 2 * k + end; }
  /// Cuts off slot s of local facet f, from the midpoint towards slot s+1 to that towards s+2.
  static constexpr int cut(int f, int s) { return kHalves + 3 * f + s; }
  /// From the centre to the midpoint of local edge k.
  static constexpr int spoke(int k) { return kHalves + kCuts + k; }
};

/// Numbering of the fine vertices: corners, midpoints of edges, the centre.
template <typename Shape>
struct FineVertices {
  static constexpr int kCount = Shape::kVertices + Shape::kEdges + (Shape::kVertices == 6 ? 1 : 0);
  static constexpr int midpoint(int k) { return Shape::kVertices + k; }
};

/// Coefficients of a fine simplex in terms of the coarse cell's edges or facets.
template <std::size_t N>
using Row = std::array<double, N>;

/// @brief The linear rule inside one cell (SCHEME.md section 4), by labels of fine vertices
/// (split_tables.h): any fine edge or facet as a row over the cell's edges (lower to higher local
/// vertex) or outward facets.
template <typename Shape>
class LocalLinear {
 public:
  explicit LocalLinear(const LinearRules& rules) : rules_(rules) {}

  using EdgeRow = Row<Shape::kEdges>;
  using FacetRow = Row<Shape::kFacets>;

  /// Number and direction of the fine edge between two labels (FineEdges).
  std::pair<int, int> find(int a, int b) const {
    constexpr int v = Shape::kVertices;
    if (a > b && !(a == kCentreLabel && !kTet)) {
      const auto [edge, sign] = find(b, a);
      return {edge, -sign};
    }
    if (!kTet && (a == kCentreLabel || b == kCentreLabel)) {
      return a == kCentreLabel ? std::pair{FineEdges<Shape>::spoke(b - v), 1}
                               : std::pair{FineEdges<Shape>::spoke(a - v), -1};
    }
    if (a < v) {  // from a corner to the midpoint of one of its edges
      const auto& [i, j] = Shape::edges[b - v];
      return {FineEdges<Shape>::half(b - v, a == j ? 1 : 0), a == i ? 1 : -1};
    }
    const CutEdge cut = SplitTables<Shape>::cut(a, b);
    return {FineEdges<Shape>::cut(cut.facet, cut.corner),
            cut.from == (cut.corner + 1) % 3 ? 1 : -1};
  }

  EdgeRow edge(int a, int b) const {
    EdgeRow row{};
    const auto [e, sign] = find(a, b);
    if (e < FineEdges<Shape>::kHalves) {
      row[e / 2] = sign * LinearRules::kHalf[0];
    } else if (e < FineEdges<Shape>::kHalves + FineEdges<Shape>::kCuts) {
      const int f = (e - FineEdges<Shape>::kHalves) / 3, s = (e - FineEdges<Shape>::kHalves) % 3;
      // Here it runs from the slot after the corner to the one after that.
      const double along = s == 1 ? -sign : sign;
      for (int k = 0; k < 4; ++k) {
        const int p = Shape::facets[f][LinearRules::kCutInputs[k][0]];
        const int q = Shape::facets[f][LinearRules::kCutInputs[k][1]];
        const double w = along * LinearRules::kCut[s][k];
        row[kCellTables<Shape>.edgeBetween[p][q]] += p < q ? w : -w;
      }
    } else {
      for (int k = 0; k < Shape::kEdges; ++k) {
        row[k] = sign * rules_.octSpoke[e - FineEdges<Shape>::spoke(0)][k];
      }
    }
    return row;
  }

  /// A fine facet along the order of its labels.
  FacetRow facet(int a, int b, int c) const {
    FacetRow row{};
    const ChildFacet child = SplitTables<Shape>::get().childFacet(a, b, c);
    const double sign = child.arrangement < 3 ? 1 : -1;
    if (child.inside) {
      for (int k = 0; k < Shape::kFacets; ++k) row[k] = sign * inside(child.facet, k);
    } else {
      row[child.facet] = sign * LinearRules::kQuarter[0];
    }
    return row;
  }

  double inside(int f, int k) const {
    if constexpr (kTet) {
      return rules_.tetFacet[f][k];
    } else {
      return rules_.octFacet[f][k];
    }
  }

 private:
  static constexpr bool kTet = Shape::kVertices == 4;
  const LinearRules& rules_;
};

}  // namespace octet
