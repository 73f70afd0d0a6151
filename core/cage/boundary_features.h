// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../topology/complex.h"
#include "sharp_edges.h"

namespace octet {

/// Which boundary vertices of a cage are to lie on which sharp edges of the surface that it fills.
struct BoundaryFeatures {
  std::vector<Index> corners;  ///< per vertex: the surface's vertex that it goes to, or kNone
  std::vector<Index> chains;   ///< per vertex: the sharp chain that it goes to, or kNone
  std::vector<std::array<Index, 2>> edges;  ///< boundary edges along chains, ascending
};

/// @brief Finds paths of boundary edges that follow the sharp chains of a surface: from the vertex
/// nearest to one corner to that of the next, past the vertices nearest to the chain. Paths have no
/// vertex in common but at corners, and no two edges of one facet. Chains too short for the cage,
/// and those with no path near them, get none.
/// @param positions  the cage's vertices, on the surface as far as they reach it
/// @param spacing    its edge length
BoundaryFeatures findBoundaryFeatures(const Complex& complex, const Array<Vec3>& positions,
                                      const TriangleSurface& surface, const SharpEdges& sharp,
                                      double spacing);

}  // namespace octet
