// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../refine/linear_refinement.h"
#include "../refine/refiner.h"

namespace octet {

/// @brief The patch test of SCHEME.md section 7 on the inside of one level, for a method that
/// places vertices itself: PatchTest goes by the places of the refiner.
///
/// Corrects D2 at every fine edge without a vertex on the boundary, by the row of least norm on the
/// facets of its cells, so that constant fluxes are exact on every facet without a vertex there. On
/// a lattice there is nothing to correct. Memory is linear in the fine level. Thread safe.
class InnerPatchTest {
 public:
  /// @param refiner       with star rows and without patch test
  /// @param level         the coarse level
  /// @param oldPositions  of the coarse level, `newPositions` of the fine one
  InnerPatchTest(const Refiner& refiner, int level, const Array<Vec3>& oldPositions,
                 const Array<Vec3>& newPositions);

  /// Corrects a flux that was refined by star rows.
  void correct(const Cochain<2>& coarse, Cochain<2>* fine) const;

 private:
  /// R of SCHEME.md, by fine edge; rounding and edges at the boundary are 0.
  Array<Vec3> residuals(const Refiner& refiner, int level, const Array<Vec3>& oldPositions,
                        const Array<Vec3>& newPositions) const;
  Cochain<2> linear(const Cochain<2>& coarse) const;

  const Complex &c_, &f_;
  LinearRefinement linear_;
  Array<Vec3> areas_;                         ///< of fine facets, as linear refinement has them
  std::vector<std::pair<Index, Vec3>> rows_;  ///< edges and lambda: C_ef = lambda . A_f
};

}  // namespace octet
