// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>

#include "../topology/complex.h"

namespace octet {

/// @brief Distortion of a cell from the regular one: the sum over its corners' tetrahedra of f^2,
/// f = |J|^2 / (3 det(J)^(2/3)) the inverse mean ratio (1 when regular, infinite when flat; P.
/// Knupp, Algebraic mesh quality metrics, 2001). A tetrahedron is its own corner; an octahedron has
/// eight, over its facets and seen from its centroid.
struct CellShape {
  double distortion = 0;
  double minVolume6 = HUGE_VAL;  ///< least of six times the corners' signed volumes
  Vec3 gradient = Vec3::Zero();  ///< of the distortion, for the vertex asked for
};

/// Measures a cell. @param vertex  local vertex for the gradient, or -1 for none
CellShape measureShape(const Complex& complex, const Array<Vec3>& positions, Index cell,
                       int vertex = -1);

/// Six times the volume of a corner of the regular cell whose edges have length 1.
constexpr double kTetCorner6 = 0.70710678118654752, kOctCorner6 = 0.35355339059327376;

}  // namespace octet
