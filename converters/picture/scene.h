// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include <octet/core/base/types.h>

namespace octet {

/// @brief What the renderer draws. Lengths are in units in which the whole is about 1 across;
/// colours are linear light, 0 to 1.
struct Scene {
  /// A round tube along a polyline, closed by spheres.
  struct Tube {
    std::vector<Vec3> points;
    std::vector<Vec3> colours;  ///< one per point, or one for all
    double radius = 0;
    bool lit = true;  ///< false: its colour as it is, like a drawn line
  };
  /// A cone, or a cylinder when both radii are the same.
  struct Cone {
    Vec3 from, to;
    double radiusFrom = 0, radiusTo = 0;
    Vec3 colour;
  };
  /// A surface of triangles, flat or in colours per point.
  struct Surface {
    std::vector<Vec3> points;
    std::vector<Vec3> colours;  ///< one per point, or one for all
    std::vector<std::array<Index, 3>> triangles;
    double opacity = 1;  ///< seen face on; less than 1 grows towards the silhouette
  };

  std::vector<Tube> tubes;
  std::vector<Cone> cones;
  Surface surface;
  Vec3 background = Vec3::Ones();
};

}  // namespace octet
