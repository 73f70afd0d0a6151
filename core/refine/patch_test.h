// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "../base/scratch.h"
#include "../rules/cell_kernels.h"
#include "../topology/boundary.h"
#include "boundary_mode.h"
#include "star_sums.h"

namespace octet {

/// Refines a 1-form by one step.
using RefineEdges = std::function<void(const double* coarse, double* fine)>;

/// @brief By how much refinement of the vector potential of constant fluxes misses the potential at
/// the new positions: R of SCHEME.md section 7, a vector per fine edge. What is rounding is 0.
/// @param oldPositions  of the coarse level, `newPositions` of the fine one; any common origin
Array<Vec3> patchTestResiduals(const Complex& fine, const RefineEdges& refine,
                               const Array<Vec3>& oldPositions, const Array<Vec3>& newPositions);

/// The facets of the cells around an edge, ascending, each once: those that a row C_e may use.
std::vector<Index> facetsAround(const Complex& complex, Index edge);

/// @brief The correction of D2 that makes constant fluxes exact on any mesh (SCHEME.md section 7):
/// a row C_e of least norm per edge with sum_f C_ef A_f = R_e, where R is by how much smoothing the
/// vector potential of constants misses the potential at the new positions.
///
/// Every row is A_f . lambda_e on the facets f around e, so three numbers per edge are stored, and
/// the area vectors of the coarse facets, from which linear refinement gives the fine ones. Static
/// for an animated asset. Thread safe.
class PatchTest {
 public:
  /// @param refine        the step without correction
  /// @param oldPositions  of the coarse level, `newPositions` of the fine one; any common origin
  PatchTest(const Complex& fine, const Boundary& boundary, const CellKernels& kernels,
            const RefineEdges& refine, ScratchPool* scratch, const Array<Vec3>& oldPositions,
            const Array<Vec3>& newPositions);

  /// Is there nothing to correct? So where the mesh is an affine lattice.
  bool empty() const { return coarseAreas_.empty(); }

  /// Adds a coarse cell's part of C, applied to the linear refinement of a 2-form, to `values` of
  /// its fine edges; `facets` are the cell's own coefficients, outward.
  template <typename Shape>
  void addCell(Index cell, const double* facets, const ClosureEdges<Shape>& closure,
               double* values) const;
  /// Completes the sum over cells: the wall rows, if any, and facets that the cells counted twice.
  void finish(BoundaryMode mode, const double* coarseFacets, double* edges) const;

  /// Calls `add(fine facet, weight)` for the row C_e of a fine edge.
  template <typename Add>
  void row(Index edge, BoundaryMode mode, double weight, const Add& add) const;

 private:
  class Builder;
  /// The boundary facets at either end of a boundary edge, each once.
  template <typename Visit>
  void visitWallFacets(Index edge, const Visit& visit) const;
  /// Area vector of a fine facet, as linear refinement has it.
  Vec3 area(Index fineFacet) const;

  const Complex& c_;  // coarse
  const Complex& f_;  // fine
  const Boundary& boundary_;
  const CellKernels& kernels_;
  Array<Vec3> coarseAreas_;
  Array<Vec3> multipliers_;      // lambda_e, with all cells around an edge
  Array<Vec3> wallMultipliers_;  // per boundary edge, with boundary facets at its ends
  // Where two cells share two facets, an edge's star can hold a facet twice that is not at the
  // edge: fine edge and coarse facet, ascending.
  std::vector<std::pair<Index, Index>> countedTwice_;
};

template <typename Visit>
void PatchTest::visitWallFacets(Index edge, const Visit& visit) const {
  const Index a = boundary_.row(f_.edges[edge][0]), b = boundary_.row(f_.edges[edge][1]);
  for (const RingStep* step = boundary_.ringBegin(a); step != boundary_.ringEnd(a); ++step) {
    visit(step->facet);
  }
  for (const RingStep* step = boundary_.ringBegin(b); step != boundary_.ringEnd(b); ++step) {
    if (!facetHasEdge(f_, step->facet, edge)) visit(step->facet);
  }
}

template <typename Add>
void PatchTest::row(Index edge, BoundaryMode mode, double weight, const Add& add) const {
  if (empty()) return;
  const bool onWall = mode == BoundaryMode::Walls && f_.edgeOnBoundary(edge);
  const Vec3& lambda = onWall ? wallMultipliers_[boundary_.edgeRow(edge)] : multipliers_[edge];
  if (lambda.isZero(0)) return;
  std::vector<Index> facets;
  if (onWall) {
    visitWallFacets(edge, [&](Index f) { facets.push_back(f); });
    std::sort(facets.begin(), facets.end());
  } else {
    facets = facetsAround(f_, edge);
  }
  for (const Index f : facets) add(f, weight * lambda.dot(area(f)));
}

}  // namespace octet
