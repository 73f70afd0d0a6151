// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "../base/context.h"
#include "smoothing.h"
#include "sparse_row.h"

namespace octet {

class Refiner;

/// @brief Rows of one subdivision step S_k, k = 0, 1 or 2: how a coefficient on the fine level
/// depends on those of the coarse one (SCHEME.md sections 4 to 8), composed of the rules' own rows.
/// Agrees with the step to rounding, on every mesh and in both boundary modes. Thread safe; refers
/// to what it is made from.
class StepAdjoint {
 public:
  /// @param smoothing  null: linear subdivision
  StepAdjoint(const Complex& fine, const LatticeSites& sites, const LinearRules& linear,
              const Smoothing* smoothing, const Correction& correction);

  const Complex& coarse() const { return c_; }
  const Complex& fine() const { return f_; }

  /// The row of a fine vertex over coarse vertices.
  void addVertex(Index fineVertex, double weight, RowSum* sum) const;
  /// The row of a fine edge over coarse edges.
  void addEdge(Index fineEdge, double weight, RowSum* sum) const;
  /// The row of a fine facet over coarse facets.
  void addFacet(Index fineFacet, double weight, RowSum* sum) const;

 private:
  void listLatticeSlots();
  template <std::size_t N, typename Add>
  void averageRow(const Array<std::array<LatticeRef, N>>& refs, Index slot, double weight,
                  const Add& add) const;
  template <typename Add>
  void regularEdgeRow(Index fineEdge, double weight, const Add& add) const;

  const Complex& c_;
  const Complex& f_;
  const LatticeSites& sites_;
  const LinearRules& linear_;
  const Smoothing* smoothing_;
  Correction correction_;
  // Of regular simplices: site and class, as site * 8 + class; else kNone.
  Array<Index> edgeSlots_, facetSlots_;
};

/// @brief The adjoint of refinement: turns functionals of the finest level's coefficients into the
/// same functionals of the control coefficients. Exact to rounding; only the simplices that occur
/// are visited. Thread safe.
template <int K>
class RefinementAdjoint {
  static_assert(K == 1 || K == 2, "vector fields");

 public:
  /// @throws InputError for a refiner with BoundaryRows::Star
  RefinementAdjoint(const Refiner& refiner, BoundaryMode mode);

  /// @param rows  over coefficients of the finest level
  /// @return the same number of rows, over control coefficients
  std::vector<SparseRow> pullBack(std::vector<SparseRow> rows, const Context& context = {}) const;

 private:
  std::vector<SparseRow> pullBackStep(const StepAdjoint& step,
                                      const std::vector<SparseRow>& rows) const;

  std::vector<StepAdjoint> steps_;  // from the control mesh to the finest level
};

}  // namespace octet
