// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <octet/core/cage/triangle_surface.h>

namespace octet {

struct SurfaceReadOptions {
  /// Of a .vdb: the grid to read; empty takes the first scalar grid.
  std::string grid;
  /// Of a .vdb: the value on the surface. Absent: 0 for a level set, half the largest value for any
  /// other grid, such as a fog volume.
  std::optional<double> isovalue;
};

/// @brief Reads a surface that encloses a body: triangles or polygons from .obj or .stl (text or
/// binary), or the surface of a level set or fog volume in a .vdb. Coordinates are taken as they
/// are.
///
/// Vertices at the same position are merged, as .stl needs. The surface of a .vdb is extracted at
/// the resolution of its grid, by OpenVDB's volumeToMesh.
/// @throws InputError with the file: another format, unreadable, empty, truncated, a coordinate
/// that is no finite number, no such grid, no surface at that value. That it is closed is for
/// checkClosed to tell.
TriangleSurface readSurface(const std::string& path, const SurfaceReadOptions& options = {});

/// Does readSurface know this file's extension?
bool isSurfaceFile(const std::string& path);

}  // namespace octet
