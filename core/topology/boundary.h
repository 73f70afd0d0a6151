// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "complex.h"
#include "local_rows.h"

namespace octet {

/// How a boundary vertex moves on the wall surface (SCHEME.md section 8): with all its
/// neighbours (Loop's scheme), along its two creases (cubic B-spline), or not at all.
enum class BoundaryKind : std::uint8_t { Smooth, Crease, Corner };

/// One step around a boundary vertex: an edge seen from it, and the boundary facet that follows,
/// counterclockwise seen from outside.
struct RingStep {
  EdgeRef edge;
  Index facet;
  std::int8_t facetSign;  ///< +1 when the facet's stored orientation points outward
  bool firstOfEdge;       ///< false when an earlier step has the same edge (sheets that touch)
};

/// Is the edge one of the facet's?
inline bool facetHasEdge(const Complex& complex, Index facet, Index edge) {
  const auto& own = complex.facetEdges[facet];
  return own[0].index() == edge || own[1].index() == edge || own[2].index() == edge;
}

/// @brief The boundary surface of one level: its facets, edges and vertices as compact lists, rings
/// around its vertices, and the smoothing rows D1 and D2 that stay on it. What the rows never leave
/// is what makes walls tight: zero flux through the boundary refines to zero flux.
class Boundary {
 public:
  Boundary() = default;
  /// @param complex  any level; `corners` are vertices that stay, in ascending order.
  /// @param coarse   the boundary of the level `complex` was split from; null for a control mesh.
  Boundary(const Complex& complex, const std::vector<Index>& corners, const Boundary* coarse);

  Index vertexCount() const { return static_cast<Index>(vertices.size()); }
  Index edgeCount() const { return static_cast<Index>(edges.size()); }

  /// Row of a vertex in the lists below, or kNone off the boundary.
  Index row(Index vertex) const { return rows_[vertex]; }
  /// Position of a boundary edge in the list of edges.
  Index edgeRow(Index edge) const {
    return static_cast<Index>(std::lower_bound(edges.begin(), edges.end(), edge) - edges.begin());
  }
  const RingStep* ringBegin(Index row) const { return ring_.data() + ringBegin_[row]; }
  const RingStep* ringEnd(Index row) const { return ring_.data() + ringBegin_[row + 1]; }
  /// Number of boundary edges at a vertex.
  Index valence(Index row) const;
  /// Is the vertex smooth with one ring of six edges, as in the triangular lattice?
  bool regular(Index row) const { return regular_[row] != 0; }

  /// D1 of boundary vertex `row`: one weight on each edge that it reads, and these edges, seen from
  /// the vertex, by calls of `visit(EdgeRef)`.
  double vertexWeight(Index row) const { return weights_[row]; }
  template <typename Visit>
  void visitVertexEdges(Index row, const Complex& complex, const Visit& visit) const;
  /// D2 of boundary edges after the linear rule, over coarse facets; none on a control mesh.
  const LocalRows& edgeRows() const { return edgeRows_; }

  std::vector<Index> facets, edges, vertices;  ///< each ascending
  Array<BoundaryKind> kinds;                   ///< per row

 private:
  void list(const Complex& complex, const Boundary* coarse);
  void buildRings(const Complex& complex);
  void classify(const Complex& complex, const std::vector<Index>& corners);
  void buildEdgeRows(const Complex& complex);

  Array<Index> rows_;
  Array<Index> ringBegin_;
  Array<RingStep> ring_;
  Array<std::uint8_t> regular_;
  Array<double> weights_;
  LocalRows edgeRows_;
};

template <typename Visit>
void Boundary::visitVertexEdges(Index row, const Complex& complex, const Visit& visit) const {
  if (kinds[row] == BoundaryKind::Corner) return;
  for (const RingStep* step = ringBegin(row); step != ringEnd(row); ++step) {
    if (!step->firstOfEdge) continue;
    if (kinds[row] == BoundaryKind::Smooth || complex.edgeFlags[step->edge.index()] & kOnCrease) {
      visit(step->edge);
    }
  }
}

}  // namespace octet
