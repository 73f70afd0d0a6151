// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "complex.h"

namespace octet {

/// @brief Finds the lattice regions of a control complex: cells joined across
/// tetrahedron|octahedron facets get coordinates in one face-centred cubic lattice, wherever these
/// close up (every vertex at one point, every point with one vertex). Fills `cellRegions` and
/// `cellFrames`; children inherit them. Purely combinatorial, so any embedding of a lattice counts.
///
/// Where a component does not close up, each of its cells is a region of its own, so that nothing
/// depends on the numbering. Needs `tets`, `octs`, `facetCells` and `cellFacets`.
void findLatticeRegions(Complex* complex);

}  // namespace octet
