// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/scratch.h"
#include "../rules/cell_kernels.h"
#include "../topology/boundary.h"
#include "../topology/lattice_sites.h"
#include "star_sums.h"

namespace octet {

class PatchTest;

/// How forms are refined at the boundary (SCHEME.md section 8).
enum class BoundaryMode : std::uint8_t {
  Walls,  ///< boundary simplices use boundary simplices only: zero wall flux stays exactly zero
  Open,   ///< constants are exact everywhere, flux through a curved wall is not kept at zero
};

/// The rows of D1 and D2 of boundary simplices.
enum class BoundaryRows : std::uint8_t {
  Surface,  ///< on the boundary surface, which becomes an ordinary subdivision surface
  Star,     ///< means over the cells there are, as inside (the thesis' original rule, Fig. 5.5):
            ///< what is missing outside pulls the boundary in
};

/// The correction of D2 by the patch test (patch_test.h) and the boundary mode it is used in.
struct Correction {
  const PatchTest* patchTest = nullptr;  ///< null: none
  BoundaryMode mode = BoundaryMode::Walls;
};

/// @brief The smoothing operators M0..M3 on one level (SCHEME.md sections 5 to 8): averages over
/// lattice translates on regular simplices, the homotopy M = I - d D - D d elsewhere, on the wall
/// surface by rows that stay there.
///
/// Nothing is stored per row: rules read the lattice sites and the coarse cells. Whatever the local
/// choices of D are, the operators commute with d. `coarse` arguments are coefficients on the
/// coarse level, `linear` their linear refinement. Thread safe; refers to the level's complex,
/// boundary, sites, kernels and scratch pool, which must outlive it.
class Smoothing {
 public:
  Smoothing(const Complex& fine, const Boundary& boundary, const LatticeSites& sites,
            const CellKernels& kernels, ScratchPool* scratch,
            BoundaryRows rows = BoundaryRows::Surface);

  void apply0(const double* coarse, const double* linear, double* out) const;
  void apply1(const double* coarse, const double* linear, const Correction& correction,
              double* out) const;
  void apply2(const double* coarse, const double* linear, const Correction& correction,
              double* out) const;
  void apply3(const double* coarse, const double* linear, double* out) const;

 private:
  void classify();
  /// Is the vertex smoothed by a mean over its star?
  bool byStar(Index vertex) const {
    return rows_ == BoundaryRows::Star || !f_.vertexOnBoundary(vertex);
  }
  double cellsAtNewEdge(Index edge) const;
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
  StarSums stars_;  // over coarse cells
  // Per fine simplex: RowFlag bits.
  Array<std::uint8_t> vertices_, edges_, facets_, cells_;
  Array<std::uint8_t> needsStarRows_;  // per coarse cell: has an irregular edge or vertex
};

}  // namespace octet
