// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "../gmsh_mesh.h"

namespace octet::gmsh_import {

/// @brief Reads a mesh file with the Gmsh SDK.
///
/// To be called once in a process. What Gmsh 4.8.4 does to a process otherwise, seen in its source
/// and by trying with some 700 damaged files:
/// - A section of a `.msh` with more entries than it says, a VTK cell with more than 100 nodes or a
///   negative time step write or read beyond their arrays: mostly a crash (signals 6 and 11), else
///   spoilt memory. No exception tells of it.
/// - Numbers of entries are taken on trust: some hundred bytes can ask for any amount of memory.
/// - A `.msh` that is none, and a file FILE.opt beside any mesh FILE, are run as Gmsh scripts,
///   which can call any program; hence checkMeshFile, and the private name that readGmshMesh gives
///   the file.
/// - The locale of the process is set, messages are printed until told otherwise, and exceptions of
///   type std::string come from the midst of the reader, which leaves its half-built model behind.
/// It was not seen to hang or to exit.
/// @throws InputError with Gmsh's reason; IoError without the library
GmshMesh readWithGmsh(const std::string& path);

}  // namespace octet::gmsh_import
