// SPDX-License-Identifier: Apache-2.0
#include "step_adjoint.h"

#include <tbb/enumerable_thread_specific.h>

#include "../base/parallel.h"
#include "refiner.h"

namespace octet {
namespace {

constexpr Index kSlotsPerSite = 8;  // at least the number of classes of any degree
static_assert(kFacetClasses <= kSlotsPerSite && kEdgeClasses <= kSlotsPerSite);

}  // namespace

StepAdjoint::StepAdjoint(const Complex& fine, const LatticeSites& sites, const LinearRules& linear,
                         const Smoothing* smoothing, const Correction& correction)
    : c_(*fine.coarse),
      f_(fine),
      sites_(sites),
      linear_(linear),
      smoothing_(smoothing),
      correction_(correction) {
  if (smoothing_) listLatticeSlots();
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

/// M of a regular simplex: the average over its translates.
template <std::size_t N, typename Add>
void StepAdjoint::averageRow(const Array<std::array<LatticeRef, N>>& refs, Index slot,
                             double weight, const Add& add) const {
  const Index site = slot / kSlotsPerSite;
  const auto k = static_cast<std::size_t>(slot % kSlotsPerSite);
  const double own = weight * refs[site][k].sign();
  for (int n = 0; n <= kNeighbours; ++n) {
    const LatticeRef ref = refs[sites_.hop(site, static_cast<std::uint8_t>(n))][k];
    if (ref.exists()) add(ref.index(), own * translateWeight(n) * ref.sign());
  }
}

/// D2 of a regular edge, as an irregular facet beside it reads it, over fine facets.
template <typename Add>
void StepAdjoint::regularEdgeRow(Index e, double weight, const Add& add) const {
  const Index site = edgeSlots_[e] / kSlotsPerSite;
  const auto k = static_cast<std::size_t>(edgeSlots_[e] % kSlotsPerSite);
  const double own = weight * sites_.edges[site][k].sign();
  sites_.visitChain(site, Lattice::get().edgeHomotopy[k],
                    [&](Index at, std::uint8_t simplexClass, double w) {
                      const LatticeRef ref = sites_.facets[at][simplexClass];
                      if (ref.exists()) add(ref.index(), own * w * ref.sign());
                    });
}

void StepAdjoint::addVertex(Index v, double weight, RowSum* sum) const {
  const ChildOf vertex = c_.children().vertex(v);
  switch (vertex.origin) {
    case Origin::Vertex:
      sum->add(vertex.parent, weight);
      break;
    case Origin::Edge:
      for (const Index end : c_.edges[vertex.parent]) sum->add(end, weight / 2);
      break;
    default:
      for (const Index corner : c_.octs[vertex.parent]) sum->add(corner, weight / 6);
  }
  if (!smoothing_) return;
  const auto derivative = [&](Index e, double w) {
    sum->add(c_.edges[e][0], w);
    sum->add(c_.edges[e][1], -w);
  };
  smoothing_->vertexRow(v, weight, derivative);
  smoothing_->moveRow(v, weight, derivative);
}

void StepAdjoint::addEdge(Index e, double weight, RowSum* sum) const {
  const auto add = [&](Index k, double w) { sum->add(k, w); };
  const auto addLinear = [&](Index fine, double w) { linearRow<1>(c_, linear_, fine, w, add); };
  if (!smoothing_) return addLinear(e, weight);
  if (edgeSlots_[e] != kNone) {
    averageRow(sites_.edges, edgeSlots_[e], weight, addLinear);
  } else {
    addLinear(e, weight);
    smoothing_->vertexRow(f_.edges[e][0], weight, add);
    smoothing_->vertexRow(f_.edges[e][1], -weight, add);
  }
  smoothing_->moveRow(f_.edges[e][0], weight, add);
  smoothing_->moveRow(f_.edges[e][1], -weight, add);
  smoothing_->edgeRow(e, correction_, -weight, [&](Index facet, double w) {
    for (const EdgeRef& ref : c_.facetEdges[facet]) add(ref.index(), w * ref.sign());
  });
}

void StepAdjoint::addFacet(Index f, double weight, RowSum* sum) const {
  const auto add = [&](Index k, double w) { sum->add(k, w); };
  const auto addLinear = [&](Index fine, double w) { linearRow<2>(c_, linear_, fine, w, add); };
  if (!smoothing_) return addLinear(f, weight);
  const bool regular = facetSlots_[f] != kNone;
  if (regular) {
    averageRow(sites_.facets, facetSlots_[f], weight, addLinear);
  } else {
    addLinear(f, weight);
    smoothing_->facetRow(c_.children().facet(f), -weight, [&](Index cell, double w) {
      for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
        const FacetRef ref = c_.cellFacet(cell, k);
        add(ref.index(), w * c_.cellSigns[cell] * ref.sign());
      }
    });
  }
  for (const EdgeRef& e : f_.facetEdges[f]) {
    smoothing_->edgeRow(e.index(), correction_, -weight * e.sign(), add);
    if (!regular && edgeSlots_[e.index()] != kNone) {
      regularEdgeRow(e.index(), -weight * e.sign(), addLinear);
    }
  }
}

template <int K>
RefinementAdjoint<K>::RefinementAdjoint(const Refiner& refiner, BoundaryMode mode) {
  for (int level = 0; level < refiner.levels(); ++level)
    steps_.push_back(refiner.rows(level, mode));
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
                                                      const Context& context) const {
  const std::size_t levels = steps_.size();
  for (std::size_t level = levels; level-- > 0;) {
    context.report({"influence of coefficients", levels - 1 - level, levels, "levels"});
    rows = pullBackStep(steps_[level], rows);
  }
  if (levels > 0) {
    context.report({"influence of coefficients", levels, levels, "levels"});
  }
  return rows;
}

template class RefinementAdjoint<1>;
template class RefinementAdjoint<2>;

}  // namespace octet
