// SPDX-License-Identifier: Apache-2.0
#include "step_adjoint.h"

#include <tbb/enumerable_thread_specific.h>

#include "../base/parallel.h"
#include "../rules/smoothing_rules.h"
#include "refiner_level.h"

namespace octet {
namespace {

constexpr Index kSlotsPerSite = 8;  // at least the number of classes of any degree
static_assert(kFacetClasses <= kSlotsPerSite && kEdgeClasses <= kSlotsPerSite);

/// A column of a cell kernel's matrix, over the cell's edges or facets.
template <typename Shape>
const CellKernel<Shape>& kernelOf(const CellKernels& kernels) {
  if constexpr (Shape::kVertices == 4) {
    return kernels.tet;
  } else {
    return kernels.oct;
  }
}

/// Local edge of a cell in the star of one of its edges.
int localEdgeAt(const Complex& complex, const CellAtEdge& at) {
  return complex.isTet(at.cell) ? kCellTables<Tetrahedron>.edgeBetween[at.start][at.end]
                                : kCellTables<Octahedron>.edgeBetween[at.start][at.end];
}

}  // namespace

StepAdjoint::StepAdjoint(const Refiner& refiner, int level, BoundaryMode mode)
    : c_(refiner.complex(level)),
      f_(refiner.complex(level + 1)),
      boundary_(refiner.boundary(level + 1)),
      sites_(refiner.sites(level + 1)),
      kernels_(*refiner.kernels_),
      smoothing_(refiner.levels_[level + 1]->smoothing.get()),
      patchTest_(refiner.levels_[level + 1]->patchTest.get()),
      mode_(mode) {
  if (refiner.options_.boundaryRows == BoundaryRows::Star) {
    throw InputError("boundary rows", "influences are known for those of the surface only");
  }
  if (patchTest_ && patchTest_->empty()) patchTest_ = nullptr;
  if (!smoothing_) return;
  listLatticeSlots();
  listWallEdges();
}

void StepAdjoint::listLatticeSlots() {
  edgeSlots_.assign(f_.edgeCount(), kNone);
  facetSlots_.assign(f_.facetCount(), kNone);
  parallelFor<Index>(sites_.count(), [&](Index s) {
    for (Index k = 0; k < kEdgeClasses; ++k) {
      if (sites_.regularEdges[s] >> k & 1) {
        edgeSlots_[sites_.edges[s][k].index()] = s * kSlotsPerSite + k;
      }
    }
    for (Index k = 0; k < kFacetClasses; ++k) {
      if (sites_.regularFacets[s] >> k & 1) {
        facetSlots_[sites_.facets[s][k].index()] = s * kSlotsPerSite + k;
      }
    }
  });
}

void StepAdjoint::listWallEdges() {
  wallEdges_.assign(f_.edgeCount(), kNone);
  for (Index k = 0; k < boundary_.edgeCount(); ++k) wallEdges_[boundary_.edges[k]] = k;
}

/// L1 (SCHEME.md section 4).
template <typename Add>
void StepAdjoint::linearEdge(Index fineEdge, double weight, const Add& add) const {
  const ChildOf child = c_.children().edge(fineEdge);
  if (child.origin == Origin::Edge) {
    add(child.parent, weight / 2);
    return;
  }
  if (child.origin == Origin::Facet) {
    // (ab,ac) = bc + ac - ab, and so on: minus the edge beside the corner that leads on from it.
    constexpr double kSigns[3][3] = {{-1, 1, 1}, {1, 1, 1}, {1, -1, 1}};
    const auto& edges = c_.facetEdges[child.parent];
    const auto& signs = kSigns[child.place];
    add(edges[0].index(), weight * signs[0] * edges[0].sign() / 4);
    add(edges[1].index(), weight * signs[1] * edges[1].sign() / 4);
    add(edges[2].index(), weight * signs[2] * -edges[2].sign() / 4);
    return;
  }
  for (int k = 0; k < 12; ++k) {
    const double entry = kernels_.linear.octSpoke[child.place][k];
    const EdgeRef e = c_.octEdge(child.parent, k);
    if (entry != 0) add(e.index(), weight * entry * e.sign());
  }
}

/// L2 (SCHEME.md section 4).
template <typename Add>
void StepAdjoint::linearFacet(Index fineFacet, double weight, const Add& add) const {
  const ChildOf child = c_.children().facet(fineFacet);
  const auto addCell = [&](const auto& facets, const auto& row) {
    for (std::size_t k = 0; k < facets.size(); ++k) {
      if (row[k] != 0) add(facets[k].index(), weight * row[k] * facets[k].sign());
    }
  };
  if (child.origin == Origin::Facet) {
    add(child.parent, weight / 4);
  } else if (child.origin == Origin::Tetrahedron) {
    addCell(c_.tetFacets[child.parent], kernels_.linear.tetFacet[child.place]);
  } else {
    addCell(c_.octFacets[child.parent], kernels_.linear.octFacet[child.place]);
  }
}

/// Calls `visit(shape, coarse cell, number among FineVertices)`.
template <typename Visit>
void StepAdjoint::visitCellsAtVertex(Index v, const Visit& visit) const {
  const ChildOf child = c_.children().vertex(v);
  const auto call = [&](Index cell, int inTet, int inOct) {
    if (c_.isTet(cell)) {
      visit(Tetrahedron{}, cell, inTet);
    } else {
      visit(Octahedron{}, cell, inOct);
    }
  };
  if (child.origin == Origin::Vertex) {
    c_.visitVertexStar(v, [&](const CellAtVertex& at) { call(at.cell, at.place, at.place); });
  } else if (child.origin == Origin::Edge) {
    c_.visitEdgeStar(child.parent, [&](const CellAtEdge& at) {
      const int k = localEdgeAt(c_, at);
      call(at.cell, FineVertices<Tetrahedron>::midpoint(k), FineVertices<Octahedron>::midpoint(k));
    });
  } else {
    visit(Octahedron{}, c_.tetCount() + child.parent, FineVertices<Octahedron>::kCount - 1);
  }
}

/// D1 L1 of a vertex, over coarse edges.
template <typename Add>
void StepAdjoint::vertexRow(Index v, double weight, const Add& add) const {
  const Index row = boundary_.row(v);
  if (row != kNone) {
    // The homotopy has one weight on all edges that it reads.
    std::vector<EdgeRef> edges;
    const double sum = boundary_.vertexHomotopy(row, f_, [&](EdgeRef e) {
      edges.push_back(e);
      return 1.0;
    });
    for (const EdgeRef& e : edges) {
      linearEdge(e.index(), weight * e.sign() * sum / static_cast<double>(edges.size()), add);
    }
    return;
  }
  const Origin origin = c_.children().vertex(v).origin;
  int cells = 0;
  visitCellsAtVertex(v, [&](auto shape, Index, int) {
    // Fine cells at a midpoint: two corner children, and those between.
    constexpr int kAtMidpoint = decltype(shape)::kVertices == 4 ? 3 : 4;
    cells += origin == Origin::Vertex ? 1 : kAtMidpoint;
  });
  if (origin == Origin::Octahedron) cells = 14;  // around its centre
  visitCellsAtVertex(v, [&](auto shape, Index cell, int at) {
    using Shape = decltype(shape);
    const auto& kernel = kernelOf<Shape>(kernels_);
    for (int k = 0; k < Shape::kEdges; ++k) {
      const EdgeRef e = localEdge<Shape>(c_, cell, k);
      add(e.index(), weight * e.sign() * kernel.vertexHomotopy[k][at] / cells);
    }
  });
}

/// Calls `visit(shape, coarse cell, number among FineEdges, sign against the stored direction)`.
template <typename Visit>
void StepAdjoint::visitCellsAtEdge(Index fineEdge, const Visit& visit) const {
  const ChildOf child = c_.children().edge(fineEdge);
  if (child.origin == Origin::Edge) {
    c_.visitEdgeStar(child.parent, [&](const CellAtEdge& at) {
      const bool forward = at.start < at.end;
      const int k = localEdgeAt(c_, at);
      const int end = forward ? child.place : 1 - child.place;
      const double sign = forward ? 1 : -1;
      if (c_.isTet(at.cell)) {
        visit(Tetrahedron{}, at.cell, FineEdges<Tetrahedron>::half(k, end), sign);
      } else {
        visit(Octahedron{}, at.cell, FineEdges<Octahedron>::half(k, end), sign);
      }
    });
  } else if (child.origin == Origin::Facet) {
    for (const CellSide& side : c_.facetCells[child.parent]) {
      if (!side.exists()) continue;
      const FacetRef seen = c_.cellFacet(side.cell(), side.facet());
      int slot = 0;
      while (seen.place(slot) != child.place) ++slot;
      const double sign = seen.place((slot + 1) % 3) < seen.place((slot + 2) % 3) ? 1 : -1;
      if (c_.isTet(side.cell())) {
        visit(Tetrahedron{}, side.cell(), FineEdges<Tetrahedron>::cut(side.facet(), slot), sign);
      } else {
        visit(Octahedron{}, side.cell(), FineEdges<Octahedron>::cut(side.facet(), slot), sign);
      }
    }
  } else {
    visit(Octahedron{}, c_.tetCount() + child.parent, FineEdges<Octahedron>::spoke(child.place),
          1.0);
  }
}

Vec3 StepAdjoint::area(Index fineFacet) const {
  Vec3 sum = Vec3::Zero();
  linearFacet(fineFacet, 1, [&](Index f, double w) { sum += w * patchTest_->coarseAreas_[f]; });
  return sum;
}

/// The correction C of D2 times L2 (SCHEME.md section 7), over coarse facets.
template <typename Add>
void StepAdjoint::patchTestRow(Index e, double weight, const Add& add) const {
  if (!patchTest_) return;
  const Index onWall = wallEdges_[e];
  const bool walls = onWall != kNone && mode_ == BoundaryMode::Walls;
  const Vec3& lambda = walls ? patchTest_->wallMultipliers_[onWall] : patchTest_->multipliers_[e];
  if (lambda.isZero(0)) return;
  std::vector<Index> facets;
  if (walls) {
    for (const Index v : f_.edges[e]) {
      const Index row = boundary_.row(v);
      for (const RingStep* step = boundary_.ringBegin(row); step != boundary_.ringEnd(row); ++step)
        facets.push_back(step->facet);
    }
  } else {
    f_.visitEdgeStar(e, [&](const CellAtEdge& at) {
      for (int k = 0; k < f_.cellFacetCount(at.cell); ++k) {
        facets.push_back(f_.cellFacet(at.cell, k).index());
      }
    });
  }
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  for (const Index f : facets) linearFacet(f, weight * lambda.dot(area(f)), add);
}

/// D2 L2 of an irregular edge plus the correction of any, over coarse facets.
template <typename Add>
void StepAdjoint::edgeRow(Index e, double weight, const Add& add) const {
  if (edgeSlots_[e] == kNone && !f_.edgeOnBoundary(e)) {
    double cells = 4;
    const ChildOf child = c_.children().edge(e);
    if (child.origin == Origin::Edge) {
      cells = 0;
      c_.visitEdgeStar(child.parent, [&](const CellAtEdge&) { ++cells; });
    }
    visitCellsAtEdge(e, [&](auto shape, Index cell, int at, double sign) {
      using Shape = decltype(shape);
      const auto& kernel = kernelOf<Shape>(kernels_);
      for (int k = 0; k < Shape::kFacets; ++k) {
        const double entry = kernel.edgeHomotopy[k][at];
        if (entry == 0) continue;
        const FacetRef f = localFacet<Shape>(c_, cell, k);
        add(f.index(), weight * sign * entry * f.sign() / cells);
      }
    });
  }
  patchTestRow(e, weight, add);
  const Index k = wallEdges_[e];
  if (k == kNone) return;
  for (auto term = boundary_.edgeTermsBegin(k); term != boundary_.edgeTermsEnd(k); ++term) {
    add(c_.children().facet(term->facet).parent, weight * term->weight / 4);
  }
}

/// D2 L2 of a regular edge, as an irregular facet beside it reads it.
template <typename Add>
void StepAdjoint::regularEdgeRow(Index e, double weight, const Add& add) const {
  const Index site = edgeSlots_[e] / kSlotsPerSite, k = edgeSlots_[e] % kSlotsPerSite;
  const double sign = sites_.edges[site][k].sign();
  for (const LatticeTerm& term : Lattice::get().edgeHomotopy[k]) {
    const LatticeRef ref = sites_.facets[sites_.siteOf(site, term)][term.simplexClass];
    if (ref.exists()) linearFacet(ref.index(), weight * sign * term.weight * ref.sign(), add);
  }
}

/// d1 of a coarse 1-form.
template <typename Add>
void StepAdjoint::derivative(Index coarseFacet, double weight, const Add& add) const {
  for (const EdgeRef& e : c_.facetEdges[coarseFacet]) add(e.index(), weight * e.sign());
}

void StepAdjoint::addEdge(Index e, double weight, RowSum* sum) const {
  const auto add = [&](Index k, double w) { sum->add(k, w); };
  if (!smoothing_) {
    linearEdge(e, weight, add);
    return;
  }
  if (edgeSlots_[e] != kNone) {
    const Index site = edgeSlots_[e] / kSlotsPerSite, k = edgeSlots_[e] % kSlotsPerSite;
    const double sign = weight * sites_.edges[site][k].sign();
    for (int n = 0; n <= kNeighbours; ++n) {
      const LatticeRef ref = sites_.edges[sites_.hop(site, static_cast<std::uint8_t>(n))][k];
      if (ref.exists()) linearEdge(ref.index(), sign * translateWeight(n) * ref.sign(), add);
    }
  } else {
    linearEdge(e, weight, add);
    vertexRow(f_.edges[e][0], weight, add);
    vertexRow(f_.edges[e][1], -weight, add);
  }
  edgeRow(e, -weight, [&](Index f, double w) { derivative(f, w, add); });
}

void StepAdjoint::addFacet(Index f, double weight, RowSum* sum) const {
  const auto add = [&](Index k, double w) { sum->add(k, w); };
  if (!smoothing_) {
    linearFacet(f, weight, add);
    return;
  }
  const bool regular = facetSlots_[f] != kNone;
  if (regular) {
    const Index site = facetSlots_[f] / kSlotsPerSite, k = facetSlots_[f] % kSlotsPerSite;
    const double sign = weight * sites_.facets[site][k].sign();
    for (int n = 0; n <= kNeighbours; ++n) {
      const LatticeRef ref = sites_.facets[sites_.hop(site, static_cast<std::uint8_t>(n))][k];
      if (ref.exists()) linearFacet(ref.index(), sign * translateWeight(n) * ref.sign(), add);
    }
  } else {
    linearFacet(f, weight, add);
    // D3 L3 d2 on a child of a coarse facet; between the children of one cell it vanishes.
    const ChildOf child = c_.children().facet(f);
    if (child.origin == Origin::Facet && !c_.facetOnBoundary(child.parent)) {
      for (int side = 0; side < 2; ++side) {
        const Index cell = c_.facetCells[child.parent][side].cell();
        const double share = c_.isTet(cell) ? kTetFacetWeight * LinearRules::kTetToTet
                                            : kOctFacetWeight * LinearRules::kOctToOct;
        const double w = (side == 0 ? -weight : weight) * share * c_.cellSigns[cell];
        for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
          const FacetRef ref = c_.cellFacet(cell, k);
          add(ref.index(), w * ref.sign());
        }
      }
    }
  }
  for (const EdgeRef& e : f_.facetEdges[f]) {
    edgeRow(e.index(), -weight * e.sign(), add);
    if (!regular && edgeSlots_[e.index()] != kNone) {
      regularEdgeRow(e.index(), -weight * e.sign(), add);
    }
  }
}

template <int K>
RefinementAdjoint<K>::RefinementAdjoint(const Refiner& refiner, BoundaryMode mode) {
  for (int level = 0; level < refiner.levels(); ++level) steps_.emplace_back(refiner, level, mode);
}

template <int K>
std::vector<SparseRow> RefinementAdjoint<K>::pullBackStep(
    const StepAdjoint& step, const std::vector<SparseRow>& rows) const {
  // The step's rows, of those fine simplices that occur.
  constexpr Index kUnused = -1;
  std::vector<Index> place(static_cast<std::size_t>(step.fine().count(K)), kUnused);
  std::vector<Index> used;
  for (const SparseRow& row : rows) {
    for (const Index k : row.index) {
      if (place[k] != kUnused) continue;
      place[k] = static_cast<Index>(used.size());
      used.push_back(k);
    }
  }
  const Index coarseCount = step.coarse().count(K);
  tbb::enumerable_thread_specific<RowSum> sums([&] { return RowSum(coarseCount); });
  std::vector<SparseRow> stepRows(used.size());
  parallelFor<std::size_t>(
      used.size(),
      [&](std::size_t k) {
        RowSum& sum = sums.local();
        if constexpr (K == 1) {
          step.addEdge(used[k], 1, &sum);
        } else {
          step.addFacet(used[k], 1, &sum);
        }
        stepRows[k] = sum.take();
      },
      64);
  std::vector<SparseRow> result(rows.size());
  parallelFor<std::size_t>(
      rows.size(),
      [&](std::size_t r) {
        RowSum& sum = sums.local();
        for (std::size_t k = 0; k < rows[r].size(); ++k) {
          const SparseRow& through = stepRows[place[rows[r].index[k]]];
          for (std::size_t j = 0; j < through.size(); ++j) {
            sum.add(through.index[j], rows[r].weight[k] * through.weight[j]);
          }
        }
        result[r] = sum.take();
      },
      16);
  return result;
}

template <int K>
std::vector<SparseRow> RefinementAdjoint<K>::pullBack(std::vector<SparseRow> rows,
                                                      const ProgressCallback& progress) const {
  const std::size_t levels = steps_.size();
  for (std::size_t level = levels; level-- > 0;) {
    reportProgress(progress, {"influence of coefficients", levels - 1 - level, levels, "levels"});
    rows = pullBackStep(steps_[level], rows);
  }
  if (levels > 0) {
    reportProgress(progress, {"influence of coefficients", levels, levels, "levels"});
  }
  return rows;
}

template class RefinementAdjoint<1>;
template class RefinementAdjoint<2>;

}  // namespace octet
