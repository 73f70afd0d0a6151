// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "../control_asset/control_asset.h"

namespace octet {

/// @brief Reads a tetrahedral mesh through the Gmsh SDK as a control asset: `.msh` (versions 2.2
/// and 4.1, text and binary), `.mesh` (Medit, text) or `.vtk` (legacy up to version 4.2).
///
/// Nodes of the tetrahedra become vertices in the order of their numbers (tags), tetrahedra
/// likewise; other nodes are dropped. Up axis is Z, the name is the file's without extension.
///
/// Each view of a `.msh` becomes a form of the view's name; elements it does not list are 0, and
/// more than one time step makes frames, numbered as the time steps:
/// | data                     | form                                        |
/// |--------------------------|---------------------------------------------|
/// | NodeData                 | 0-form; data of dropped nodes is ignored    |
/// | ElementData on lines     | 1-form, along the line's nodes              |
/// | ElementData on triangles | 2-form, oriented as the triangle's nodes    |
/// | ElementData on tetrahedra| 3-form                                      |
///
/// Lines of physical curves named "crease" or "creases" are the creases, instead of the default
/// guess; points of physical points named "corner" or "corners" the corners (case does not matter).
///
/// Gmsh runs in a program of its own, limited in time and memory (gmsh_program.h), so it leaves no
/// state in this process and prints nothing. Several threads may read at once.
///
/// @throws InputError with the file, the place and the reason: not a file that Gmsh reads, other
/// cells than linear tetrahedra, data that is no form; where ControlMesh::build refuses the mesh,
/// its places count vertices and tetrahedra from 0. IoError without octetvdb-gmsh.
ControlAsset readGmshMesh(const std::string& path);

}  // namespace octet
