// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../gmsh_mesh.h"

namespace octet::gmsh_import {

/// @brief Fills volumes with tetrahedra, with Gmsh's Delaunay algorithm and optimiser; the
/// triangles stay as they are.
///
/// To be called once in a process, as readWithGmsh: on surfaces that cannot be meshed Gmsh 4.8.4
/// may throw, give up, or crash.
/// @throws InputError with Gmsh's reason; IoError without the library
GmshMesh meshVolumes(const GmshShells& shells);

}  // namespace octet::gmsh_import
