// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "triangle_surface.h"

namespace octet {

/// A closed part of a surface, and where it lies among the others.
struct SurfacePart {
  std::vector<Index> triangles;  ///< of the whole surface, ascending
  double volume = 0;             ///< not signed
  Index depth = 0;               ///< how many other parts enclose it
  Index parent = kNone;          ///< of these, the one of most depth
};

/// @brief The parts of a closed surface that does not intersect itself, in the order of their first
/// triangles. The triangles' orientation does not matter.
std::vector<SurfacePart> surfaceParts(const TriangleSurface& surface);

/// The closed parts of a surface at one depth of nesting.
struct SurfaceLayer {
  TriangleSurface surface;
  double volume = 0;  ///< sum of the parts' volumes, not signed
  Index parts = 0;
};

/// @brief Splits a closed surface that does not intersect itself by how many other parts enclose a
/// part. What lies within an odd number of parts is body, the rest is not: layer 0 encloses bodies,
/// layer 1 cavities in them, layer 2 bodies in these. The triangles' orientation does not matter.
std::vector<SurfaceLayer> nestingLayers(const TriangleSurface& surface);

}  // namespace octet
