// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "refiner.h"
#include "sparse_row.h"

namespace octet {

/// @brief Rows of one subdivision step S_k, k = 1 or 2: how a coefficient on the fine level depends
/// on those of the coarse one (SCHEME.md sections 4 to 8). What Smoothing and PatchTest apply to
/// whole levels, written out for single simplices; both agree to rounding, on every mesh and in
/// both boundary modes. Thread safe; the refiner must outlive it.
class StepAdjoint {
 public:
  /// @param level  of the coarse side, 0 <= level < refiner.levels()
  /// @throws InputError for a refiner with BoundaryRows::Star
  StepAdjoint(const Refiner& refiner, int level, BoundaryMode mode);

  const Complex& coarse() const { return c_; }
  const Complex& fine() const { return f_; }

  /// The row of a fine edge over coarse edges.
  void addEdge(Index fineEdge, double weight, RowSum* sum) const;
  /// The row of a fine facet over coarse facets.
  void addFacet(Index fineFacet, double weight, RowSum* sum) const;

 private:
  template <typename Add>
  void linearEdge(Index fineEdge, double weight, const Add& add) const;
  template <typename Add>
  void linearFacet(Index fineFacet, double weight, const Add& add) const;
  template <typename Add>
  void vertexRow(Index fineVertex, double weight, const Add& add) const;
  template <typename Add>
  void edgeRow(Index fineEdge, double weight, const Add& add) const;
  template <typename Add>
  void patchTestRow(Index fineEdge, double weight, const Add& add) const;
  template <typename Add>
  void regularEdgeRow(Index fineEdge, double weight, const Add& add) const;
  template <typename Add>
  void derivative(Index coarseFacet, double weight, const Add& add) const;
  template <typename Visit>
  void visitCellsAtVertex(Index fineVertex, const Visit& visit) const;
  template <typename Visit>
  void visitCellsAtEdge(Index fineEdge, const Visit& visit) const;
  void listLatticeSlots();
  void listWallEdges();
  Vec3 area(Index fineFacet) const;

  const Complex& c_;
  const Complex& f_;
  const Boundary& boundary_;
  const LatticeSites& sites_;
  const CellKernels& kernels_;
  const Smoothing* smoothing_;  // null: linear subdivision
  const PatchTest* patchTest_;  // null: nothing to correct
  BoundaryMode mode_;
  // Of regular simplices: site and class, as site * 8 + class; else kNone.
  Array<Index> edgeSlots_, facetSlots_;
  Array<Index> wallEdges_;  // position of a fine edge in the boundary's list; else kNone
};

/// @brief The adjoint of refinement: turns functionals of the finest level's coefficients into the
/// same functionals of the control coefficients. Exact to rounding; only the simplices that occur
/// are visited. Thread safe.
template <int K>
class RefinementAdjoint {
  static_assert(K == 1 || K == 2, "vector fields");

 public:
  RefinementAdjoint(const Refiner& refiner, BoundaryMode mode);

  /// @param rows  over coefficients of the finest level
  /// @return the same number of rows, over control coefficients
  std::vector<SparseRow> pullBack(std::vector<SparseRow> rows,
                                  const ProgressCallback& progress = {}) const;

 private:
  std::vector<SparseRow> pullBackStep(const StepAdjoint& step,
                                      const std::vector<SparseRow>& rows) const;

  std::vector<StepAdjoint> steps_;  // from the control mesh to the finest level
};

}  // namespace octet
