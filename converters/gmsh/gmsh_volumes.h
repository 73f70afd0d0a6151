// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "gmsh_mesh.h"

namespace octet::gmsh_import {

/// Closed surfaces of triangles, and the volumes that they bound.
struct GmshShells {
  std::vector<double> coordinates;               ///< of all nodes; node k has the tag k + 1
  std::vector<std::vector<std::size_t>> shells;  ///< tags of the triangles' nodes, by shell
  /// Shells of each volume: the one around it, then those of its cavities.
  std::vector<std::vector<std::size_t>> volumes;
  double edgeLength = 0;  ///< wanted inside
};

/// @brief Fills volumes with tetrahedra, with Gmsh's Delaunay algorithm and optimiser; the
/// triangles stay as they are. Failures are told in the result's `error`.
///
/// @warning To be called in a process of its own (runInChild), once, as readWithGmsh: on surfaces
/// that cannot be meshed Gmsh 4.8.4 may throw, give up, or crash.
GmshMesh meshVolumes(const GmshShells& shells);

}  // namespace octet::gmsh_import
