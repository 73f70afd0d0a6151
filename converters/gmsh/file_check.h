// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace octet::gmsh_import {

enum class MeshFormat { Msh, Medit, Vtk };

struct MeshFile {
  MeshFormat format = MeshFormat::Msh;
  std::uint64_t bytes = 0;
  std::optional<std::uint64_t> elements;  ///< as many as the file says, where that is written
};

/// @brief Checks a mesh file before Gmsh sees it, for what Gmsh would do worse than refuse it.
///
/// Gmsh runs a `.msh` that does not begin as one as a script, which may call any program; it takes
/// a Medit file that ends early, or whose lines it cannot read, for a smaller or random mesh; and
/// it skips rows beyond the number that a section gives. What Gmsh refuses by itself is left to it.
/// @throws InputError with a line or section as place, without the file.
MeshFile checkMeshFile(const std::string& path);

}  // namespace octet::gmsh_import
