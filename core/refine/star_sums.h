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
        sign[at] = facet.place((s + 1) % 3) < facet.place((s + 2) % 3) ? 1.0 : -1.0;
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

  /// Number of fine cells at a fine vertex, given as coarse vertex, coarse edge (its midpoint).
  int cellsAtVertex(Index coarseVertex) const {
    return static_cast<int>(vertexBegin_[coarseVertex + 1] - vertexBegin_[coarseVertex]);
  }
  int cellsAtMidpoint(Index coarseEdge) const;
  /// Number of cells at a coarse edge, and at each of its halves.
  int cellsAtEdge(Index coarseEdge) const {
    return static_cast<int>(edgeBegin_[coarseEdge + 1] - edgeBegin_[coarseEdge]);
  }

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
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    double atStart = 0, atEnd = 0;
    for (std::uint32_t k = edgeBegin_[e]; k < edgeBegin_[e + 1]; ++k) {
      const EdgeEntry entry = edgeEntries_[k];
      const double* half = parts + offset<kTet, kOct>(entry.cell()) + 2 * entry.edge();
      atStart += half[entry.forward() ? 0 : 1];
      atEnd += half[entry.forward() ? 1 : 0];
    }
    out[children.half(e, 0)] = atStart;
    out[children.half(e, 1)] = atEnd;
  });
  parallelFor<Index>(c_.facetCount(), [&](Index f) {
    double sum[3] = {0, 0, 0};
    for (const CellSide& side : c_.facetCells[f]) {
      if (!side.exists()) continue;
      const bool tet = c_.isTet(side.cell());
      const double* cut = parts + offset<kTet, kOct>(side.cell()) +
                          (tet ? FineEdges<Tetrahedron>::cut(side.facet(), 0)
                               : FineEdges<Octahedron>::cut(side.facet(), 0));
      const FacetRef seen = c_.cellFacet(side.cell(), side.facet());
      for (int s = 0; s < 3; ++s) sum[seen.place(s)] += cut[s];
    }
    std::copy(sum, sum + 3, out + children.cut(f, 0));
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
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    if (!wanted(v)) return;
    double sum = 0;
    for (std::uint32_t k = vertexBegin_[v]; k < vertexBegin_[v + 1]; ++k) {
      const VertexEntry entry = vertexEntries_[k];
      sum += parts[offset<kTet, kOct>(entry.cell()) + static_cast<std::size_t>(entry.place())];
    }
    out[v] = sum;
  });
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    const Index midpoint = children.midpoint(e);
    if (!wanted(midpoint)) return;
    double sum = 0;
    for (std::uint32_t k = edgeBegin_[e]; k < edgeBegin_[e + 1]; ++k) {
      const EdgeEntry entry = edgeEntries_[k];
      const int at = c_.isTet(entry.cell()) ? FineVertices<Tetrahedron>::midpoint(entry.edge())
                                            : FineVertices<Octahedron>::midpoint(entry.edge());
      sum += parts[offset<kTet, kOct>(entry.cell()) + static_cast<std::size_t>(at)];
    }
    out[midpoint] = sum;
  });
}

}  // namespace octet
