// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "../geometry/box_tree.h"

namespace octet {

/// A surface of triangles, in world units.
struct TriangleSurface {
  Array<Vec3> vertices;
  Array<std::array<Index, 3>> triangles;

  Box bounds() const;
  /// Volume enclosed: positive when the triangles' right-handed normals point outward.
  double volume() const;
};

/// The surface of a box. @throws InputError when it is empty or not finite
TriangleSurface boxSurface(const Box& box);

/// A point of a surface.
struct SurfacePoint {
  Vec3 position = Vec3::Zero();
  Index triangle = kNone;
  double distance = 0;  ///< from the query point, not signed
};

/// @brief Finds the nearest point of a surface, exactly (to rounding). Thread safe.
class ClosestPoints {
 public:
  /// The surface must outlive this.
  explicit ClosestPoints(const TriangleSurface& surface);
  SurfacePoint find(const Vec3& p) const;

 private:
  const TriangleSurface& surface_;
  BoxTree tree_;
};

/// @brief Refuses what does not enclose a body: no triangles, an index out of range, a coordinate
/// that is no finite number, and an edge that does not have an even number of triangles (an open
/// surface). Vertices are compared by index: weld them before.
/// @throws InputError with the first such place ("vertices[3]", "triangles[7]")
void checkClosed(const TriangleSurface& surface);

/// Two triangles that pass through each other, or lie on each other.
struct Intersection {
  Index triangle, other;
};

/// The first pair of triangles that intersect other than in vertices and edges they share.
std::optional<Intersection> findSelfIntersection(const TriangleSurface& surface);

/// @brief Merges vertices at the same position, to the bit, and drops triangles that this leaves
/// without three vertices, as well as vertices no triangle uses.
TriangleSurface welded(const TriangleSurface& surface);

}  // namespace octet
