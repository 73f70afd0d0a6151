// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/scratch.h"
#include "../rules/cell_kernels.h"
#include "../rules/smoothing_rules.h"
#include "../topology/boundary.h"
#include "../topology/lattice_sites.h"
#include "../topology/local_rows.h"
#include "flux_stars.h"
#include "linear_blocks.h"
#include "patch_test.h"
#include "star_sums.h"
#include "vertex_moves.h"

namespace octet {

/// The correction of D2 by the patch test (patch_test.h) and the boundary mode it is used in.
struct Correction {
  const PatchTest* patchTest = nullptr;  ///< null: none
  BoundaryMode mode = BoundaryMode::Walls;
};

/// @brief The smoothing operators M0..M3 on one level (SCHEME.md sections 5 to 8): averages over
/// lattice translates on regular simplices, the homotopy M = I - d D - D d elsewhere, on the wall
/// surface by rows that stay there. Irregular stars add rows H1 and H2 of their own to D1 L1 and
/// D2 L2.
///
/// Only those are stored: rules read the lattice sites and the coarse cells. Whatever the local
/// choices of D are, the operators commute with d. `coarse` arguments are coefficients on the
/// coarse level, `linear` their linear refinement. Thread safe; refers to the level's complex,
/// boundary, sites, kernels and scratch pool, which must outlive it.
class Smoothing {
 public:
  /// @param coarseBoundary  of the level that `fine` was split from
  Smoothing(const Complex& fine, const Boundary& boundary, const Boundary& coarseBoundary,
            const LatticeSites& sites, const CellKernels& kernels, ScratchPool* scratch,
            BoundaryRows rows = BoundaryRows::Smooth);

  /// Lets irregular stars move their children: those whose moves are sound (soundMoves). Before it
  /// no star moves anything.
  /// @param before  positions of the coarse level
  /// @param after   positions without moves; with them on return
  void move(int level, const Array<Vec3>& before, Array<Vec3>* after);
  /// Lets all irregular stars move their children.
  void moveAll() { setMoves(asked_); }

  void apply0(const double* coarse, const double* linear, double* out) const;
  void apply1(const double* coarse, const double* linear, const Correction& correction,
              double* out) const;
  void apply2(const double* coarse, const double* linear, const Correction& correction,
              double* out) const;
  void apply3(const double* coarse, const double* linear, double* out) const;

  /// @name Rows of the homotopy after the linear rule, `add(coarse simplex, weight)` by term
  /// What the operators above apply to a whole level, for single simplices that are not regular.
  /// @{
  /// D1 L1 of a fine vertex, over coarse edges.
  template <typename Add>
  void vertexRow(Index vertex, double weight, const Add& add) const;
  /// H1 of a fine vertex, over coarse edges.
  template <typename Add>
  void moveRow(Index vertex, double weight, const Add& add) const {
    moves_.row(vertex, weight, add);
  }
  /// D2 L2 + H2 of a fine edge, over coarse facets; of a regular edge the correction and H2 alone.
  template <typename Add>
  void edgeRow(Index edge, const Correction& correction, double weight, const Add& add) const;
  /// D3 L3 of a fine facet, over coarse cells. It is the same for the four children of a coarse
  /// facet, since a child's weight (4:1) makes up for its share (1:4); between the children of one
  /// cell it vanishes for the same reason.
  template <typename Add>
  void facetRow(const ChildOf& facet, double weight, const Add& add) const;
  /// @}

 private:
  enum RowFlag : std::uint8_t {
    kRegular = 1,   // smoothed by the average over translates
    kNeedsRow = 2,  // its row of D is read by an irregular simplex
    kStarRow = 4,   // irregular: its row of D is a mean over its star
    kMoved = 8,     // has a row of H1; of an edge: regular, but an end has one
  };
  void classify();
  void setMoves(const std::vector<StarMoves>& stars);
  /// Is the vertex smoothed by a mean over its star?
  bool byStar(Index vertex) const {
    return rows_ == BoundaryRows::Star || !f_.vertexOnBoundary(vertex);
  }
  template <typename Wanted>
  void vertexRows(const double* coarseEdges, const Wanted& wanted, double* out) const;
  template <typename Read>
  void boundaryVertexRows(const Read& edge, double* out) const;
  void edgeRows(const double* coarseFacets, const Correction& correction, double* out) const;
  void facetRows(const double* coarseCells, double* out) const;

  const Complex& c_;  // coarse
  const Complex& f_;  // fine
  const Boundary& boundary_;
  const LatticeSites& sites_;
  const CellKernels& kernels_;
  ScratchPool* scratch_;
  BoundaryRows rows_;
  StarSums stars_;                // over coarse cells
  std::vector<StarMoves> asked_;  // until it is known which are made
  LocalRows moves_;               // H1
  FluxStars fluxes_;              // H2
  // Per fine simplex: RowFlag bits.
  Array<std::uint8_t> vertices_, edges_, facets_, cells_;
  Array<std::uint8_t> needsStarRows_;  // per coarse cell: has an irregular edge or vertex
};

// ---- implementation of the rows --------------------------------------------------------------

/// A fine simplex' column of a cell's matrix as a row over the cell's own simplices, `own(k)` being
/// a reference to the k-th, divided by the number of cells at the fine simplex.
template <int N, int M, typename Own, typename Add>
void columnRow(const double (&matrix)[N][M], int column, const Own& own, int cells, double weight,
               const Add& add) {
  for (int k = 0; k < N; ++k) {
    if (matrix[k][column] == 0) continue;
    const auto ref = own(k);
    add(ref.index(), weight * ref.sign() * matrix[k][column] / cells);
  }
}

template <typename Add>
void Smoothing::vertexRow(Index v, double weight, const Add& add) const {
  if (!byStar(v)) {
    const Index row = boundary_.row(v);
    boundary_.visitVertexEdges(row, f_, [&](EdgeRef e) {
      linearRow<1>(c_, kernels_.linear, e.index(), weight * e.sign() * boundary_.vertexWeight(row),
                   add);
    });
    return;
  }
  const ChildOf vertex = c_.children().vertex(v);
  const int cells = stars_.cellsAtVertex(vertex);
  stars_.visitVertex(vertex, [&](Index cell, int k) {
    withShape(c_, cell, [&](auto shape) {
      using Shape = decltype(shape);
      if (k >= FineVertices<Shape>::kCount) return;  // a tetrahedron has no centre
      columnRow(
          kernels_.of<Shape>().vertexHomotopy, k,
          [&](int own) { return localEdge<Shape>(c_, cell, own); }, cells, weight, add);
    });
  });
}

template <typename Add>
void Smoothing::edgeRow(Index e, const Correction& correction, double weight,
                        const Add& add) const {
  if (edges_[e] & kStarRow) {
    const ChildOf edge = c_.children().edge(e);
    const int cells = stars_.cellsAtEdge(edge);
    stars_.visitEdge(edge, [&](Index cell, int k, double sign) {
      withShape(c_, cell, [&](auto shape) {
        using Shape = decltype(shape);
        columnRow(
            kernels_.of<Shape>().edgeHomotopy, k,
            [&](int own) { return localFacet<Shape>(c_, cell, own); }, cells, weight * sign, add);
      });
    });
  }
  if (correction.patchTest) {
    correction.patchTest->row(e, correction.mode, weight, [&](Index facet, double w) {
      linearRow<2>(c_, kernels_.linear, facet, w, add);
    });
  }
  if (rows_ != BoundaryRows::Star) boundary_.edgeRows().row(e, weight, add);
  fluxes_.row(e, weight, add);
}

template <typename Add>
void Smoothing::facetRow(const ChildOf& facet, double weight, const Add& add) const {
  if (facet.origin != Origin::Facet || c_.facetOnBoundary(facet.parent)) return;
  for (int side = 0; side < 2; ++side) {
    const Index cell = c_.facetCells[facet.parent][side].cell();
    const double share = c_.isTet(cell) ? kTetFacetWeight * LinearRules::kTetToTet
                                        : kOctFacetWeight * LinearRules::kOctToOct;
    add(cell, (side == 0 ? weight : -weight) * share);
  }
}

}  // namespace octet
