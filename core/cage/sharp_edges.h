// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "triangle_surface.h"

namespace octet {

/// Angle from flat, in degrees, beyond which an edge is sharp: that of a control mesh' creases.
inline constexpr double kSharpAngle = 40;

/// Connected sharp edges shorter than this altogether, in edges of a cage, are noise to it.
inline constexpr double kLeastSharp = 2;

/// The sharp edges of a surface, joined to chains that run from corner to corner or around.
struct SharpEdges {
  std::vector<std::array<Index, 2>> edges;  ///< vertices ascending, in lexicographic order
  std::vector<Index> chains;                ///< of each edge, numbered from 0
  Index chainCount = 0;
  /// Vertices at which one or more than two sharp edges end, or two that turn by more than the
  /// angle; ascending.
  std::vector<Index> corners;
};

/// @brief Finds the edges at which a surface turns by more than an angle, or that do not have two
/// triangles. Triangles may have any orientation; those without area make no edge sharp.
/// @param angle  degrees from flat, between 0 and 180
/// @param leastLength  connected sharp edges that are shorter altogether are taken for noise
SharpEdges findSharpEdges(const TriangleSurface& surface, double angle = kSharpAngle,
                          double leastLength = 0);

/// Each chain as a surface of triangles without area, for ClosestPoints to find points on it.
std::vector<TriangleSurface> chainsAsSurfaces(const TriangleSurface& surface,
                                              const SharpEdges& sharp);

}  // namespace octet
