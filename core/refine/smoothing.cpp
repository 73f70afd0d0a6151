// SPDX-License-Identifier: Apache-2.0
#include "smoothing.h"

#include "../base/parallel.h"
#include "../forms/coboundary.h"
#include "interior_moves.h"
#include "wall_moves.h"

namespace octet {
namespace {

double read(LatticeRef ref, const double* values) {
  return ref.exists() ? ref.sign() * values[ref.index()] : 0.0;
}

/// Coefficients in lattice layout: those based at a site side by side, along their classes.
template <std::size_t N>
ScratchPool::Loan gather(ScratchPool* scratch, const Array<std::array<LatticeRef, N>>& slots,
                         const double* values) {
  auto result = scratch->take(slots.size() * N);
  parallelFor<std::size_t>(slots.size(), [&](std::size_t s) {
    for (std::size_t c = 0; c < N; ++c) result[s * N + c] = read(slots[s][c], values);
  });
  return result;
}

/// Average over translates of every regular simplex.
template <std::size_t N>
void averageTranslates(const LatticeSites& sites, const Array<std::array<LatticeRef, N>>& slots,
                       const Array<std::uint8_t>& regular, const ScratchPool::Loan& values,
                       double* out) {
  parallelFor<Index>(sites.count(), [&](Index s) {
    if (!regular[s]) return;
    double near[N] = {}, far[N] = {};
    const auto& neighbours = sites.neighbours[s];
    for (int k = 0; k < 12; ++k) {
      const double* other = values.data() + static_cast<std::size_t>(neighbours[k]) * N;
      for (std::size_t c = 0; c < N; ++c) near[c] += other[c];
    }
    for (int k = 12; k < kNeighbours; ++k) {
      const double* other = values.data() + static_cast<std::size_t>(neighbours[k]) * N;
      for (std::size_t c = 0; c < N; ++c) far[c] += other[c];
    }
    const double* own = values.data() + static_cast<std::size_t>(s) * N;
    for (std::size_t c = 0; c < N; ++c) {
      if (!(regular[s] >> c & 1)) continue;
      out[slots[s][c].index()] =
          slots[s][c].sign() * (translateWeight(kSelf) * own[c] + translateWeight(0) * near[c] +
                                translateWeight(12) * far[c]);
    }
  });
}

/// Rows of a lattice homotopy for the regular simplices that `needs(index)` says need them.
template <std::size_t N, std::size_t M, typename Needs>
void latticeRows(const LatticeSites& sites, const Array<std::array<LatticeRef, N>>& slots,
                 const Array<std::uint8_t>& regular,
                 const std::array<std::vector<LatticeTerm>, N>& homotopy, const Needs& needs,
                 const ScratchPool::Loan& values, double* out) {
  parallelFor<Index>(sites.count(), [&](Index s) {
    for (std::size_t c = 0; c < N; ++c) {
      if (!(regular[s] >> c & 1) || !needs(slots[s][c].index())) continue;
      double sum = 0;
      sites.visitChain(s, homotopy[c], [&](Index at, std::uint8_t simplexClass, double weight) {
        sum += weight * values[static_cast<std::size_t>(at) * M + simplexClass];
      });
      out[slots[s][c].index()] = slots[s][c].sign() * sum;
    }
  });
}

/// sum_k matrix[k][:] * input[k]
template <int N, int M>
void multiply(const double (&matrix)[N][M], const double* input, double* out) {
  double sum[M] = {};
  for (int k = 0; k < N; ++k) {
    for (int m = 0; m < M; ++m) sum[m] += matrix[k][m] * input[k];
  }
  std::copy(sum, sum + M, out);
}

}  // namespace

Smoothing::Smoothing(const Complex& fine, const Boundary& boundary, const Boundary& coarseBoundary,
                     const LatticeSites& sites, const CellKernels& kernels, ScratchPool* scratch,
                     BoundaryRows rows)
    : c_(*fine.coarse),
      f_(fine),
      boundary_(boundary),
      sites_(sites),
      kernels_(kernels),
      scratch_(scratch),
      rows_(rows),
      stars_(c_) {
  const IrregularStars irregular(c_);
  asked_ = interiorMoves(irregular);
  // Stars of a control mesh overlap at walls, and would disturb each other.
  if (rows == BoundaryRows::Smooth && c_.coarse) wallMoves(c_, coarseBoundary, &asked_);
  fluxes_ = FluxStars(irregular, f_);
  vertices_.assign(f_.vertexCount(), 0);
  classify();
}

void Smoothing::move(int level, const Array<Vec3>& before, Array<Vec3>* after) {
  setMoves(soundMoves(f_, level, before, std::move(asked_), after));
}

void Smoothing::setMoves(const std::vector<StarMoves>& stars) {
  moves_ = moveRows(stars);
  asked_ = {};
  for (const Index v : moves_.fine()) vertices_[v] |= kMoved;
  parallelFor<Index>(f_.edgeCount(), [&](Index e) {
    if (!(edges_[e] & kRegular)) return;
    for (const Index v : f_.edges[e]) edges_[e] |= vertices_[v] & kMoved;
  });
}

void Smoothing::classify() {
  edges_.assign(f_.edgeCount(), 0);
  facets_.assign(f_.facetCount(), 0);
  cells_.assign(f_.cellCount(), 0);
  parallelFor<Index>(sites_.count(), [&](Index s) {
    for (int c = 0; c < kEdgeClasses; ++c) {
      if (sites_.regularEdges[s] >> c & 1) edges_[sites_.edges[s][c].index()] = kRegular;
    }
    for (int c = 0; c < kFacetClasses; ++c) {
      if (sites_.regularFacets[s] >> c & 1) facets_[sites_.facets[s][c].index()] = kRegular;
    }
    for (int c = 0; c < kCellClasses; ++c) {
      if (sites_.regularCells[s] >> c & 1) cells_[sites_.cells[s][c].index()] = kRegular;
    }
  });
  parallelFor<Index>(f_.edgeCount(), [&](Index e) {
    if (edges_[e] & kRegular) return;
    if (rows_ == BoundaryRows::Star || !f_.edgeOnBoundary(e)) edges_[e] = kStarRow;
    for (const Index v : f_.edges[e]) {
      if (byStar(v)) orRelaxed(&vertices_[v], kNeedsRow);
    }
  });
  parallelFor<Index>(f_.facetCount(), [&](Index f) {
    if (facets_[f] & kRegular) return;
    for (const EdgeRef& e : f_.facetEdges[f]) orRelaxed(&edges_[e.index()], kNeedsRow);
  });
  parallelFor<Index>(f_.cellCount(), [&](Index cell) {
    if (cells_[cell] & kRegular) return;
    for (int k = 0; k < f_.cellFacetCount(cell); ++k) {
      orRelaxed(&facets_[f_.cellFacet(cell, k).index()], kNeedsRow);
    }
  });

  needsStarRows_.resize(c_.cellCount());
  const auto needs = [&](auto shape, Index cell) {
    const ClosureEdges<decltype(shape)> closure(c_, cell);
    return std::any_of(closure.index.begin(), closure.index.end(),
                       [&](Index e) { return !(edges_[e] & kRegular); });
  };
  parallelFor<Index>(c_.cellCount(), [&](Index cell) {
    needsStarRows_[cell] = c_.isTet(cell) ? needs(Tetrahedron{}, cell) : needs(Octahedron{}, cell);
  });
}

/// D1 of interior vertices applied to the linear refinement of a 1-form, where `wanted(vertex)`.
template <typename Wanted>
void Smoothing::vertexRows(const double* coarseEdges, const Wanted& wanted, double* out) const {
  const auto fill = [&](auto shape, Index cell, double* values) {
    using Shape = decltype(shape);
    double edges[Shape::kEdges];
    for (int k = 0; k < Shape::kEdges; ++k) {
      const EdgeRef e = localEdge<Shape>(c_, cell, k);
      edges[k] = e.sign() * coarseEdges[e.index()];
    }
    multiply(kernels_.of<Shape>().vertexHomotopy, edges, values);
  };
  stars_.vertices(scratch_, fill, wanted, out);
  // So far sums over the star; the row is their mean.
  const ChildNumbering children = c_.children();
  parallelFor<Index>(f_.vertexCount(), [&](Index v) {
    if (!wanted(v)) return;
    out[v] /= stars_.cellsAtVertex(children.vertex(v));
  });
}

/// D1 of boundary vertices, `edge(EdgeRef)` giving the coefficients of a fine 1-form.
template <typename Read>
void Smoothing::boundaryVertexRows(const Read& edge, double* out) const {
  if (rows_ == BoundaryRows::Star) return;
  parallelFor<Index>(boundary_.vertexCount(), [&](Index row) {
    double sum = 0;
    boundary_.visitVertexEdges(row, f_, [&](EdgeRef e) { sum += edge(e); });
    out[boundary_.vertices[row]] = boundary_.vertexWeight(row) * sum;
  });
}

/// D2 of irregular edges plus the patch test's correction of all edges, applied to the linear
/// refinement of a 2-form.
void Smoothing::edgeRows(const double* coarseFacets, const Correction& correction,
                         double* out) const {
  const ChildNumbering children = c_.children();
  const PatchTest* const patchTest =
      correction.patchTest && !correction.patchTest->empty() ? correction.patchTest : nullptr;
  const auto fill = [&](auto shape, Index cell, double* values) {
    using Shape = decltype(shape);
    using Edges = FineEdges<Shape>;
    if (!needsStarRows_[cell] && !patchTest) {
      std::fill(values, values + Edges::kCount, 0.0);
      return;
    }
    const ClosureEdges<Shape> closure(c_, cell);
    double facets[Shape::kFacets];
    for (int k = 0; k < Shape::kFacets; ++k) {
      const FacetRef f = localFacet<Shape>(c_, cell, k);
      facets[k] = f.sign() * coarseFacets[f.index()];
    }
    if (needsStarRows_[cell]) {
      multiply(kernels_.of<Shape>().edgeHomotopy, facets, values);
      for (int k = 0; k < Edges::kCount; ++k) {
        const Index e = closure.index[k];
        const double cells = stars_.cellsAtEdge(children.edge(e));
        values[k] = edges_[e] & kStarRow ? values[k] * closure.sign[k] / cells : 0.0;
      }
    } else {
      std::fill(values, values + Edges::kCount, 0.0);
    }
    if (patchTest) patchTest->addCell(cell, facets, closure, values);
  };
  stars_.edges(scratch_, fill, out);
  if (patchTest) patchTest->finish(correction.mode, coarseFacets, out);
  if (rows_ != BoundaryRows::Star) boundary_.edgeRows().addTo(coarseFacets, out);
  fluxes_.apply(coarseFacets, out);
}

/// D3 of irregular facets applied to the linear refinement of a 3-form, one for all children of a
/// coarse facet.
void Smoothing::facetRows(const double* coarseCells, double* out) const {
  parallelFor<Index>(c_.facetCount(), [&](Index f) {
    double sum = 0;
    facetRow({Origin::Facet, f, 0}, 1,
             [&](Index cell, double weight) { sum += weight * coarseCells[cell]; });
    out[f] = sum;
  });
}

void Smoothing::apply0(const double* coarse, const double* linear, double* out) const {
  auto edges = scratch_->take(c_.edgeCount());
  coboundary0(c_, coarse, edges.data());
  // At a regular vertex, too, the mean over the star is the average over translates.
  vertexRows(
      edges.data(), [&](Index v) { return byStar(v); }, out);
  boundaryVertexRows(
      [&](EdgeRef e) {
        return e.sign() * (linear[f_.edges[e.index()][1]] - linear[f_.edges[e.index()][0]]);
      },
      out);
  moves_.addTo(edges.data(), out);
  parallelFor<Index>(f_.vertexCount(), [&](Index v) { out[v] = linear[v] - out[v]; });
}

void Smoothing::apply1(const double* coarse, const double* linear, const Correction& correction,
                       double* out) const {
  auto facets = scratch_->take(c_.facetCount());
  auto rows = scratch_->take(f_.edgeCount());
  auto vertices = scratch_->take(f_.vertexCount());
  coboundary1(c_, coarse, facets.data());
  edgeRows(facets.data(), correction, rows.data());
  vertexRows(
      coarse, [&](Index v) { return vertices_[v] & kNeedsRow; }, vertices.data());
  boundaryVertexRows([&](EdgeRef e) { return e.sign() * linear[e.index()]; }, vertices.data());
  moves_.addTo(coarse, vertices.data());
  const auto moved = [&](Index v) {
    double sum = 0;
    moveRow(v, 1, [&](Index e, double weight) { sum += weight * coarse[e]; });
    return sum;
  };
  averageTranslates(sites_, sites_.edges, sites_.regularEdges,
                    gather(scratch_, sites_.edges, linear), out);
  parallelFor<Index>(f_.edgeCount(), [&](Index e) {
    const auto& [a, b] = f_.edges[e];
    double average = edges_[e] & kRegular ? out[e] : linear[e] - (vertices[b] - vertices[a]);
    if (edges_[e] & kMoved) average -= moved(b) - moved(a);
    out[e] = average - rows[e];
  });
}

void Smoothing::apply2(const double* coarse, const double* linear, const Correction& correction,
                       double* out) const {
  auto rows = scratch_->take(f_.edgeCount());
  auto regularRows = scratch_->take(sites_.count() ? f_.edgeCount() : 0);
  edgeRows(coarse, correction, rows.data());
  {
    const auto values = gather(scratch_, sites_.facets, linear);
    averageTranslates(sites_, sites_.facets, sites_.regularFacets, values, out);
    const auto needs = [&](Index e) { return (edges_[e] & kNeedsRow) != 0; };
    latticeRows<kEdgeClasses, kFacetClasses>(sites_, sites_.edges, sites_.regularEdges,
                                             Lattice::get().edgeHomotopy, needs, values,
                                             regularRows.data());
  }
  auto facets = scratch_->take(c_.facetCount());
  {
    auto cells = scratch_->take(c_.cellCount());
    coboundary2(c_, coarse, cells.data());
    facetRows(cells.data(), facets.data());
  }
  const ChildNumbering children = c_.children();
  parallelFor<Index>(f_.facetCount(), [&](Index f) {
    const auto& edges = f_.facetEdges[f];
    if (facets_[f] & kRegular) {
      for (const EdgeRef& e : edges) out[f] -= e.sign() * rows[e.index()];
      return;
    }
    const ChildOf child = children.facet(f);
    double sum = linear[f] - (child.origin == Origin::Facet ? facets[child.parent] : 0.0);
    for (const EdgeRef& e : edges) {
      double row = rows[e.index()];
      if (edges_[e.index()] & kRegular) row += regularRows[e.index()];
      sum -= e.sign() * row;
    }
    out[f] = sum;
  });
}

void Smoothing::apply3(const double* coarse, const double* linear, double* out) const {
  auto regularRows = scratch_->take(sites_.count() ? f_.facetCount() : 0);
  {
    auto values = gather(scratch_, sites_.cells, linear);
    averageTranslates(sites_, sites_.cells, sites_.regularCells, values, out);
    const auto needs = [&](Index f) { return (facets_[f] & kNeedsRow) != 0; };
    // Masses count as positively oriented in space; a mirrored region turns lattice chains over.
    parallelFor<Index>(sites_.count(), [&](Index s) {
      for (int c = 0; c < kCellClasses; ++c) {
        values[static_cast<std::size_t>(s) * kCellClasses + c] *= sites_.handedness[s];
      }
    });
    latticeRows<kFacetClasses, kCellClasses>(sites_, sites_.facets, sites_.regularFacets,
                                             Lattice::get().facetHomotopy, needs, values,
                                             regularRows.data());
  }
  auto facets = scratch_->take(c_.facetCount());
  facetRows(coarse, facets.data());
  const ChildNumbering children = c_.children();
  parallelFor<Index>(f_.cellCount(), [&](Index cell) {
    if (cells_[cell] & kRegular) return;
    double sum = 0;
    for (int k = 0; k < f_.cellFacetCount(cell); ++k) {
      const FacetRef f = f_.cellFacet(cell, k);
      const ChildOf child = children.facet(f.index());
      if (facets_[f.index()] & kRegular) {
        sum += f.sign() * regularRows[f.index()];
      } else if (child.origin == Origin::Facet) {
        sum += f.sign() * facets[child.parent];
      }
    }
    out[cell] = linear[cell] - f_.cellSigns[cell] * sum;
  });
}

}  // namespace octet
