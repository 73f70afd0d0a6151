// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../topology/complex.h"

namespace octet {

/// @brief How well a control mesh is shaped, and whether its boundary is a manifold.
struct CageQuality {
  /// Smallest and largest dihedral angle inside a cell, degrees. In the lattice they are 70.5 in
  /// tetrahedra and 109.5 in octahedra.
  double minDihedral = 0, maxDihedral = 0;
  double minVolume = 0, maxVolume = 0;  ///< of cells, cubic world units, not signed
  /// Least of the cells' volumes over those of regular cells with the same longest edge (an
  /// octahedron's longest edge beside its diagonals).
  double minShape = 0;
  Index components = 0;  ///< parts of the mesh that share no facet
  /// Boundary vertices and edges at which the solid touches itself; 0 when it is a manifold.
  Index touchingVertices = 0, touchingEdges = 0;
};

/// Measures a control mesh or any level refined from one.
CageQuality measureQuality(const Complex& complex, const Array<Vec3>& positions);

}  // namespace octet
