// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "linear_refinement.h"
#include "smoothing.h"
#include "star_sums.h"

namespace octet {

/// @brief The correction of D2 that makes constant fluxes exact on any mesh (SCHEME.md section 7):
/// a row C_e of least norm per edge with sum_f C_ef A_f = R_e, where R is by how much smoothing the
/// vector potential of constants misses the potential at the new positions.
///
/// Every row is A_f . lambda_e on the facets f around e, so three numbers per edge are stored, and
/// the area vectors of the coarse facets, from which linear refinement gives the fine ones. Static
/// for an animated asset. Thread safe.
class PatchTest {
 public:
  /// @param oldPositions  of the coarse level, `newPositions` of the fine one; any common origin.
  PatchTest(const Complex& fine, const Boundary& boundary, const LinearRefinement& linear,
            const CellKernels& kernels, const Smoothing& smoothing, ScratchPool* scratch,
            const Array<Vec3>& oldPositions, const Array<Vec3>& newPositions);

  /// Is there nothing to correct? So where the mesh is an affine lattice.
  bool empty() const { return coarseAreas_.empty(); }

  /// Adds a coarse cell's part of C, applied to the linear refinement of a 2-form, to `values` of
  /// its fine edges; `facets` are the cell's own coefficients, outward.
  template <typename Shape>
  void addCell(const CellKernel<Shape>& kernel, Index cell, const double* facets,
               const ClosureEdges<Shape>& closure, double* values) const;
  /// Completes the sum over cells: the wall rows, if any, and facets that the cells counted twice.
  void finish(BoundaryMode mode, const double* coarseFacets, double* edges) const;

 private:
  friend class StepAdjoint;  // writes the same rows out
  class Builder;
  template <typename Sum, typename OfFacet>
  Sum sumOnWall(Index boundaryEdge, const OfFacet& ofFacet) const;

  const Complex& c_;  // coarse
  const Complex& f_;  // fine
  const Boundary& boundary_;
  Array<Vec3> coarseAreas_;
  Array<Vec3> multipliers_;      // lambda_e, with all cells around an edge
  Array<Vec3> wallMultipliers_;  // per boundary edge, with boundary facets at its ends
  // Where two cells share two facets, an edge's star can hold a facet twice that is not at the
  // edge: fine edge and coarse facet, ascending.
  std::vector<std::pair<Index, Index>> countedTwice_;
};

}  // namespace octet
