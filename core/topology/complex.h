// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "../rules/split_tables.h"
#include "child_numbering.h"
#include "incidence.h"

namespace octet {

/// Vertex types of the thesis' section 2.1, in their order: regular, interior on a control facet,
/// edge or vertex, and the same on the boundary. The type of a simplex is the highest of its
/// vertices.
enum class VertexType : std::uint8_t { R, X1, X2, X3, B1, B2, B3 };

/// What an edge lies on; bits, inherited under refinement.
enum EdgeFlag : std::uint8_t {
  kOnBoundary = 1,
  kOnCrease = 2,
  kOnControlEdge = 4,
  kOnControlFacet = 8,
};

/// @brief The topology of one level: cells, facets and edges with stored orientation, and their
/// incidence (SCHEME.md section 2). Structure of arrays; immutable once built, so it may be read
/// from many threads.
///
/// A simplex's orientation is the order in which its vertices are stored. Cells carry a sign,
/// decided once from the control geometry and inherited by children: +1 when the tables' "outward"
/// facets point out of the cell. Fine levels keep a pointer to the level they were split from;
/// stars need no storage beyond the control mesh's, since children are numbered in closed form.
class Complex {
 public:
  /// @name Counts
  /// @{
  Index vertexCount() const { return static_cast<Index>(vertexTypes.size()); }
  Index edgeCount() const { return static_cast<Index>(edges.size()); }
  Index facetCount() const { return static_cast<Index>(facetEdges.size()); }
  Index tetCount() const { return static_cast<Index>(tets.size()); }
  Index octCount() const { return static_cast<Index>(octs.size()); }
  Index cellCount() const { return tetCount() + octCount(); }
  /// Number of simplices of dimension k: vertices, edges, facets, cells.
  Index count(int k) const;
  /// Numbers the simplices of the level that a split of this one makes.
  ChildNumbering children() const {
    return {vertexCount(), edgeCount(), facetCount(), tetCount(), octCount()};
  }
  /// @}

  /// @name Incidence
  /// @{
  bool isTet(Index cell) const { return cell < tetCount(); }
  /// Facet i of a cell, seen as the tables' outward triple.
  FacetRef cellFacet(Index cell, int i) const {
    return isTet(cell) ? tetFacets[cell][i] : octFacets[cell - tetCount()][i];
  }
  int cellFacetCount(Index cell) const { return isTet(cell) ? 4 : 8; }
  Index cellVertex(Index cell, int i) const {
    return isTet(cell) ? tets[cell][i] : octs[cell - tetCount()][i];
  }
  int cellVertexCount(Index cell) const { return isTet(cell) ? 4 : 6; }
  /// Local edge k of a tetrahedron / octahedron, seen from its lower to its higher local vertex.
  EdgeRef tetEdge(Index tet, int k) const { return edgeOf<Tetrahedron>(tetFacets[tet], k); }
  EdgeRef octEdge(Index oct, int k) const { return edgeOf<Octahedron>(octFacets[oct], k); }
  /// The edge of a cell between two of its local vertices, seen from the first to the second.
  EdgeRef cellEdge(Index cell, int from, int to) const;
  /// The edge of a facet from place i to place j of its stored triple.
  EdgeRef facetEdge(Index facet, int i, int j) const {
    const bool forward = j == (i + 1) % 3;
    return facetEdges[facet][forward ? i : j].flippedIf(!forward);
  }
  /// The stored vertex triple of a facet.
  std::array<Index, 3> facetVertices(Index facet) const;
  bool facetOnBoundary(Index facet) const {
    return !facetCells[facet][0].exists() || !facetCells[facet][1].exists();
  }
  bool edgeOnBoundary(Index edge) const { return edgeFlags[edge] & kOnBoundary; }
  bool vertexOnBoundary(Index vertex) const { return vertexTypes[vertex] >= VertexType::B1; }
  /// @}

  /// @name Stars, computed from the closed-form numbering
  /// @{
  /// Calls `visit(CellAtVertex)` for every cell at a vertex.
  template <typename Visit>
  void visitVertexStar(Index vertex, const Visit& visit) const;
  /// Calls `visit(CellAtEdge)` for every cell at an edge.
  template <typename Visit>
  void visitEdgeStar(Index edge, const Visit& visit) const;
  /// @}

  // Arrays, one entry per simplex.
  Array<VertexType> vertexTypes;
  Array<std::array<Index, 2>> edges;          ///< vertices, in stored order
  Array<std::uint8_t> edgeFlags;              ///< EdgeFlag bits
  Array<std::array<EdgeRef, 3>> facetEdges;   ///< (s0,s1), (s1,s2), (s2,s0) of the triple
  Array<std::array<CellSide, 2>> facetCells;  ///< the cell it points out of, and into
  Array<std::array<Index, 4>> tets;
  Array<std::array<Index, 6>> octs;
  Array<std::array<FacetRef, 4>> tetFacets;
  Array<std::array<FacetRef, 8>> octFacets;
  Array<std::int8_t> cellSigns;
  std::vector<Index> cellRegions;  ///< lattice region of a cell (lattice_regions.h)
  Array<std::uint8_t> cellFrames;  ///< lattice symmetry that places the cell in its region

  std::shared_ptr<const Complex> coarse;  ///< what this was split from; null for a control mesh

  // Stars of a control mesh; empty at finer levels.
  Array<Index> vertexStarBegin, edgeStarBegin;
  Array<CellAtVertex> vertexStars;
  Array<CellAtEdge> edgeStars;

 private:
  template <typename Shape, typename Facets>
  EdgeRef edgeOf(const Facets& facets, int k) const {
    const EdgeInFacet& where = kCellTables<Shape>.edgeFacets[k][0];
    const FacetRef facet = facets[where.facet];
    return facetEdge(facet.index(), facet.place(where.start), facet.place(where.end));
  }
  template <typename Visit>
  void visitNewEdgeStar(Index edge, const Visit& visit) const;
  template <typename Visit>
  void visitNewVertexStar(Index vertex, const Visit& visit) const;
};

/// At most this many levels can be stacked; indices run out long before.
inline constexpr int kMaxLevels = 30;

// ---- implementation of the stars -------------------------------------------------------------

template <typename Visit>
void Complex::visitEdgeStar(Index edge, const Visit& visit) const {
  // Follow halves of edges up to where the edge was made, then its cells down again: the child at
  // the corner that the half keeps, with the same two places.
  const Complex* levels[kMaxLevels + 1];
  std::uint8_t halves[kMaxLevels + 1];
  int depth = 0;
  levels[0] = this;
  while (levels[depth]->coarse) {
    const ChildOf child = levels[depth]->coarse->children().edge(edge);
    if (child.origin != Origin::Edge) break;
    halves[depth] = static_cast<std::uint8_t>(child.place);
    edge = child.parent;
    levels[depth + 1] = levels[depth]->coarse.get();
    ++depth;
  }
  const auto descend = [&](CellAtEdge at) {
    for (int d = depth; d-- > 0;) {
      at.cell = levels[d + 1]->children().cornerChild(at.cell, halves[d] ? at.end : at.start);
    }
    visit(at);
  };
  if (levels[depth]->coarse) {
    levels[depth]->visitNewEdgeStar(edge, descend);
  } else {
    const Complex& control = *levels[depth];
    for (Index k = control.edgeStarBegin[edge]; k < control.edgeStarBegin[edge + 1]; ++k) {
      descend(control.edgeStars[k]);
    }
  }
}

template <typename Visit>
void Complex::visitVertexStar(Index vertex, const Visit& visit) const {
  const Complex* levels[kMaxLevels + 1];
  int depth = 0;
  levels[0] = this;
  while (levels[depth]->coarse && vertex < levels[depth]->coarse->vertexCount()) {
    levels[depth + 1] = levels[depth]->coarse.get();
    ++depth;
  }
  const auto descend = [&](CellAtVertex at) {
    for (int d = depth; d-- > 0;) {
      at.cell = levels[d + 1]->children().cornerChild(at.cell, at.place);
    }
    visit(at);
  };
  if (levels[depth]->coarse) {
    levels[depth]->visitNewVertexStar(vertex, descend);
  } else {
    const Complex& control = *levels[depth];
    for (Index k = control.vertexStarBegin[vertex]; k < control.vertexStarBegin[vertex + 1]; ++k) {
      descend(control.vertexStars[k]);
    }
  }
}

/// Edges made by the last split: inside a coarse facet, or from the centre of a coarse octahedron.
template <typename Visit>
void Complex::visitNewEdgeStar(Index edge, const Visit& visit) const {
  const Complex& c = *coarse;
  const ChildNumbering children = c.children();
  const ChildOf child = children.edge(edge);
  if (child.origin == Origin::Facet) {
    const int corner = child.place;  // stored place of the facet's vertex that the edge cuts off
    for (const CellSide& side : c.facetCells[child.parent]) {
      if (!side.exists()) continue;
      // Local vertices of the corner and of the other two, in the facet's stored order: the edge
      // runs between the midpoints towards them, from the lower stored place to the higher.
      const FacetRef seen = c.cellFacet(side.cell(), side.facet());
      const bool tet = c.isTet(side.cell());
      const std::uint8_t* triple =
          tet ? Tetrahedron::facets[side.facet()] : Octahedron::facets[side.facet()];
      int at[3];
      for (int k = 0; k < 3; ++k) at[seen.place(k)] = triple[k];
      const int x = at[corner], y = at[corner == 0 ? 1 : 0], z = at[corner == 2 ? 1 : 2];
      visit(CellAtEdge{children.cornerChild(side.cell(), x), y, z});
      const Index inner = children.innerChild(side.cell(), side.facet());
      if (tet) {
        const auto& between = kCellTables<Tetrahedron>.edgeBetween[x];
        visit(CellAtEdge{inner, kTetMidpointPlace[between[y]], kTetMidpointPlace[between[z]]});
      } else {
        // The child (ij,jl,il,centre) of outward facet (i,j,l): midpoint of places (a,b) at
        // place 0, 1 or 2.
        const auto midpointPlace = [&](int a, int b) {
          const int third = triple[0] != a && triple[0] != b   ? 0
                            : triple[1] != a && triple[1] != b ? 1
                                                               : 2;
          return (third + 1) % 3;
        };
        visit(CellAtEdge{inner, midpointPlace(x, y), midpointPlace(x, z)});
      }
    }
    return;
  }
  const Index oct = child.parent;
  const int i = Octahedron::edges[child.place][0], j = Octahedron::edges[child.place][1];
  visit(CellAtEdge{children.cornerOct(oct, i), Octahedron::opposite[i], j});
  visit(CellAtEdge{children.cornerOct(oct, j), Octahedron::opposite[j], i});
  for (const EdgeInFacet& where : kCellTables<Octahedron>.edgeFacets[child.place]) {
    const int third = 3 - where.start - where.end;
    visit(CellAtEdge{children.innerTet(oct, where.facet), 3, (third + 1) % 3});
  }
}

/// Vertices made by the last split: midpoints of coarse edges and centres of coarse octahedra.
template <typename Visit>
void Complex::visitNewVertexStar(Index vertex, const Visit& visit) const {
  const Complex& c = *coarse;
  const ChildNumbering children = c.children();
  const ChildOf child = children.vertex(vertex);
  if (child.origin == Origin::Octahedron) {
    for (int i = 0; i < 6; ++i) {
      visit(CellAtVertex{children.cornerOct(child.parent, i), Octahedron::opposite[i]});
    }
    for (int f = 0; f < 8; ++f) visit(CellAtVertex{children.innerTet(child.parent, f), 3});
    return;
  }
  c.visitEdgeStar(child.parent, [&](const CellAtEdge& at) {
    visit(CellAtVertex{children.cornerChild(at.cell, at.start), at.end});
    visit(CellAtVertex{children.cornerChild(at.cell, at.end), at.start});
    if (c.isTet(at.cell)) {
      const int k = kCellTables<Tetrahedron>.edgeBetween[at.start][at.end];
      visit(CellAtVertex{children.innerOct(at.cell), kTetMidpointPlace[k]});
    } else {
      const Index oct = at.cell - c.tetCount();
      const int k = kCellTables<Octahedron>.edgeBetween[at.start][at.end];
      for (const EdgeInFacet& where : kCellTables<Octahedron>.edgeFacets[k]) {
        const int third = 3 - where.start - where.end;
        visit(CellAtVertex{children.innerTet(oct, where.facet), (third + 1) % 3});
      }
    }
  });
}

}  // namespace octet
