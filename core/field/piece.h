// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../geometry/box_bins.h"

namespace octet {

/// A tetrahedron with a linear field of C components on it, given at its corners.
template <int C>
struct Piece {
  using Value = Eigen::Matrix<double, C, 1>;

  std::array<Vec3, 4> points;
  std::array<Value, 4> values;

  Box box() const {
    Box b;
    for (const Vec3& p : points) b.extend(p);
    return b;
  }
};

/// Barycentric coordinates as linear functions of position: lambda_i = gradients[i] . (x - origin)
/// + (i == 0). Not finite for a flat tetrahedron.
struct Barycentric {
  explicit Barycentric(const std::array<Vec3, 4>& p) : origin(p[0]) {
    const Vec3 a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
    const double perVolume = 1 / a.dot(b.cross(c));
    gradients[1] = b.cross(c) * perVolume;
    gradients[2] = c.cross(a) * perVolume;
    gradients[3] = a.cross(b) * perVolume;
    gradients[0] = -(gradients[1] + gradients[2] + gradients[3]);
  }
  bool finite() const { return gradients[0].allFinite(); }

  Vec3 origin;
  std::array<Vec3, 4> gradients;
};

/// Points this little outside a tetrahedron, in barycentric coordinates, still belong to it: no
/// point may fall between two neighbours.
inline constexpr double kSharedFacetTolerance = 1e-9;

}  // namespace octet
