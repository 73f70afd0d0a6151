// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/parallel.h"
#include "../base/scratch.h"
#include "../rules/cell_kernels.h"
#include "../topology/complex.h"

namespace octet {

/// The local edges of a coarse cell, seen from their lower to their higher local vertex.
template <typename Shape>
EdgeRef localEdge(const Complex& complex, Index cell, int k) {
  if constexpr (Shape::kVertices == 4) {
    return complex.tetEdge(cell, k);
  } else {
    return complex.octEdge(cell - complex.tetCount(), k);
  }
}

/// Facet k of a coarse cell, seen as the tables' outward triple.
template <typename Shape>
FacetRef localFacet(const Complex& complex, Index cell, int k) {
  if constexpr (Shape::kVertices == 4) {
    return complex.tetFacets[cell][k];
  } else {
    return complex.octFacets[cell - complex.tetCount()][k];
  }
}

/// Calls `body(Tetrahedron{})` or `body(Octahedron{})`, as the cell is.
template <typename Body>
void withShape(const Complex& complex, Index cell, const Body& body) {
  if (complex.isTet(cell)) {
    body(Tetrahedron{});
  } else {
    body(Octahedron{});
  }
}

/// Does the edge that cuts off a slot of a facet, from the midpoint towards the next slot to that
/// towards the one after, have its stored direction (+1)?
inline double cutSign(FacetRef facet, int slot) {
  return facet.place((slot + 1) % 3) < facet.place((slot + 2) % 3) ? 1.0 : -1.0;
}

/// The fine edges in the closure of a coarse cell, in the order of FineEdges: their index, and
/// whether the local direction is the stored one.
template <typename Shape>
struct ClosureEdges {
  std::array<Index, FineEdges<Shape>::kCount> index;
  std::array<double, FineEdges<Shape>::kCount> sign;

  ClosureEdges(const Complex& coarse, Index cell) {
    const ChildNumbering children = coarse.children();
    for (int k = 0; k < Shape::kEdges; ++k) {
      const EdgeRef e = localEdge<Shape>(coarse, cell, k);
      for (int end = 0; end < 2; ++end) {
        const int at = FineEdges<Shape>::half(k, end);
        index[at] = children.half(e.index(), e.reversed() ? 1 - end : end);
        sign[at] = e.sign();
      }
    }
    for (int f = 0; f < Shape::kFacets; ++f) {
      const FacetRef facet = localFacet<Shape>(coarse, cell, f);
      for (int s = 0; s < 3; ++s) {
        const int at = FineEdges<Shape>::cut(f, s);
        index[at] = children.cut(facet.index(), facet.place(s));
        sign[at] = cutSign(facet, s);
      }
    }
    if constexpr (Shape::kVertices == 6) {
      for (int k = 0; k < 12; ++k) {
        index[FineEdges<Shape>::spoke(k)] = children.spoke(cell - coarse.tetCount(), k);
        sign[FineEdges<Shape>::spoke(k)] = 1.0;
      }
    }
  }
};

/// @brief Sums over the stars of fine edges and vertices of what their coarse cells contribute.
/// Every coarse cell writes its contributions once, to a place of its own; then every fine simplex
/// adds up those of its coarse cells. Deterministic, parallel, linear.
///
/// A contribution is `fill(shape, cell, values)`: for edges FineEdges<Shape>::kCount values along
/// the edges' stored directions, for vertices FineVertices<Shape>::kCount values.
class StarSums {
 public:
  explicit StarSums(const Complex& coarse);

  /// Number of fine cells at a fine vertex; 1 where there is none.
  int cellsAtVertex(const ChildOf& vertex) const;
  /// Number of fine cells at a fine edge.
  int cellsAtEdge(const ChildOf& edge) const {
    if (edge.origin == Origin::Edge) {
      return static_cast<int>(edgeBegin_[edge.parent + 1] - edgeBegin_[edge.parent]);
    }
    return edge.origin == Origin::Facet && c_.facetOnBoundary(edge.parent) ? 2 : 4;
  }

  /// Calls `visit(cell, k)` for the coarse cells at a fine vertex, k its number in the cell's
  /// FineVertices.
  template <typename Visit>
  void visitVertex(const ChildOf& vertex, const Visit& visit) const;
  /// Calls `visit(cell, k, sign)` for the coarse cells at a fine edge, k its number in the cell's
  /// FineEdges, whose direction is the stored one or (-1) the opposite.
  template <typename Visit>
  void visitEdge(const ChildOf& edge, const Visit& visit) const;

  template <typename Fill>
  void edges(ScratchPool* scratch, const Fill& fill, double* out) const;
  /// Only of vertices for which `wanted(v)`; others are left alone.
  template <typename Fill, typename Wanted>
  void vertices(ScratchPool* scratch, const Fill& fill, const Wanted& wanted, double* out) const;

 private:
  /// A cell at a coarse edge, the local edge, and whether both have the same direction.
  struct EdgeEntry {
    std::uint32_t code;
    EdgeEntry() = default;
    EdgeEntry(Index cell, int edge, bool forward)
        : code(static_cast<std::uint32_t>(cell) << 5 | static_cast<std::uint32_t>(edge) << 1 |
               static_cast<std::uint32_t>(forward)) {}
    Index cell() const { return static_cast<Index>(code >> 5); }
    int edge() const { return static_cast<int>(code >> 1 & 15u); }
    bool forward() const { return code & 1u; }
  };
  /// A cell at a coarse vertex and the vertex' place in it.
  struct VertexEntry {
    std::uint32_t code;
    VertexEntry() = default;
    VertexEntry(Index cell, int place)
        : code(static_cast<std::uint32_t>(cell) << 3 | static_cast<std::uint32_t>(place)) {}
    Index cell() const { return static_cast<Index>(code >> 3); }
    int place() const { return static_cast<int>(code & 7u); }
  };

  template <int TetSize, int OctSize>
  std::size_t offset(Index cell) const {
    const std::size_t tets = static_cast<std::size_t>(c_.tetCount());
    const std::size_t k = static_cast<std::size_t>(cell);
    return k < tets ? TetSize * k : TetSize * tets + OctSize * (k - tets);
  }

  const Complex& c_;
  Array<std::uint32_t> edgeBegin_, vertexBegin_;
  Array<EdgeEntry> edgeEntries_;
  Array<VertexEntry> vertexEntries_;
};

template <typename Visit>
void StarSums::visitVertex(const ChildOf& vertex, const Visit& visit) const {
  using Tet = FineVertices<Tetrahedron>;
  using Oct = FineVertices<Octahedron>;
  if (vertex.origin == Origin::Vertex) {
    for (std::uint32_t k = vertexBegin_[vertex.parent]; k < vertexBegin_[vertex.parent + 1]; ++k) {
      visit(vertexEntries_[k].cell(), vertexEntries_[k].place());
    }
  } else if (vertex.origin == Origin::Edge) {
    for (std::uint32_t k = edgeBegin_[vertex.parent]; k < edgeBegin_[vertex.parent + 1]; ++k) {
      const EdgeEntry entry = edgeEntries_[k];
      visit(entry.cell(),
            c_.isTet(entry.cell()) ? Tet::midpoint(entry.edge()) : Oct::midpoint(entry.edge()));
    }
  } else {
    visit(c_.tetCount() + vertex.parent, Oct::kCount - 1);
  }
}

template <typename Visit>
void StarSums::visitEdge(const ChildOf& edge, const Visit& visit) const {
  using Tet = FineEdges<Tetrahedron>;
  using Oct = FineEdges<Octahedron>;
  if (edge.origin == Origin::Edge) {
    for (std::uint32_t k = edgeBegin_[edge.parent]; k < edgeBegin_[edge.parent + 1]; ++k) {
      // Halves have the same numbers in both shapes.
      const EdgeEntry entry = edgeEntries_[k];
      const int end = entry.forward() ? edge.place : 1 - edge.place;
      visit(entry.cell(), Tet::half(entry.edge(), end), entry.forward() ? 1.0 : -1.0);
    }
  } else if (edge.origin == Origin::Facet) {
    for (const CellSide& side : c_.facetCells[edge.parent]) {
      if (!side.exists()) continue;
      const FacetRef seen = c_.cellFacet(side.cell(), side.facet());
      int slot = 0;
      while (seen.place(slot) != edge.place) ++slot;
      visit(side.cell(),
            c_.isTet(side.cell()) ? Tet::cut(side.facet(), slot) : Oct::cut(side.facet(), slot),
            cutSign(seen, slot));
    }
  } else {
    visit(c_.tetCount() + edge.parent, Oct::spoke(edge.place), 1.0);
  }
}

template <typename Fill>
void StarSums::edges(ScratchPool* scratch, const Fill& fill, double* out) const {
  constexpr int kTet = FineEdges<Tetrahedron>::kCount;
  constexpr int kOct = FineEdges<Octahedron>::kCount - 12;  // spokes are the cell's own
  const ChildNumbering children = c_.children();
  const Index tets = c_.tetCount();
  auto loan = scratch->take(offset<kTet, kOct>(c_.cellCount()));
  double* const parts = loan.data();
  parallelFor<Index>(
      tets, [&](Index t) { fill(Tetrahedron{}, t, parts + offset<kTet, kOct>(t)); }, 64);
  parallelFor<Index>(
      c_.octCount(),
      [&](Index o) {
        double values[FineEdges<Octahedron>::kCount];
        fill(Octahedron{}, tets + o, values);
        std::copy(values, values + kOct, parts + offset<kTet, kOct>(tets + o));
        std::copy(values + kOct, values + kOct + 12, out + children.spoke(o, 0));
      },
      64);
  const auto sum = [&](const ChildOf& edge) {
    double result = 0;
    visitEdge(edge, [&](Index cell, int k, double) {
      result += parts[offset<kTet, kOct>(cell) + static_cast<std::size_t>(k)];
    });
    return result;
  };
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    for (int end = 0; end < 2; ++end) out[children.half(e, end)] = sum({Origin::Edge, e, end});
  });
  parallelFor<Index>(c_.facetCount(), [&](Index f) {
    for (int k = 0; k < 3; ++k) out[children.cut(f, k)] = sum({Origin::Facet, f, k});
  });
}

template <typename Fill, typename Wanted>
void StarSums::vertices(ScratchPool* scratch, const Fill& fill, const Wanted& wanted,
                        double* out) const {
  constexpr int kTet = FineVertices<Tetrahedron>::kCount;
  constexpr int kOct = FineVertices<Octahedron>::kCount - 1;  // the centre is the cell's own
  const ChildNumbering children = c_.children();
  const Index tets = c_.tetCount();
  auto loan = scratch->take(offset<kTet, kOct>(c_.cellCount()));
  double* const parts = loan.data();
  parallelFor<Index>(
      tets, [&](Index t) { fill(Tetrahedron{}, t, parts + offset<kTet, kOct>(t)); }, 64);
  parallelFor<Index>(
      c_.octCount(),
      [&](Index o) {
        double values[FineVertices<Octahedron>::kCount];
        fill(Octahedron{}, tets + o, values);
        std::copy(values, values + kOct, parts + offset<kTet, kOct>(tets + o));
        const Index centre = children.centre(o);
        if (wanted(centre)) out[centre] = values[kOct];
      },
      64);
  const auto sum = [&](Index fine, const ChildOf& vertex) {
    if (!wanted(fine)) return;
    double result = 0;
    visitVertex(vertex, [&](Index cell, int k) {
      result += parts[offset<kTet, kOct>(cell) + static_cast<std::size_t>(k)];
    });
    out[fine] = result;
  };
  parallelFor<Index>(c_.vertexCount(), [&](Index v) { sum(v, {Origin::Vertex, v, 0}); });
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    sum(children.midpoint(e), {Origin::Edge, e, 0});
  });
}

}  // namespace octet
