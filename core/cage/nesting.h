// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "triangle_surface.h"

namespace octet {

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
