// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>

#include "array.h"

namespace octet {

/// Index of a vertex, edge, facet or cell. Tetrahedra come before octahedra in the cell numbering.
using Index = std::int32_t;

/// "No such simplex."
inline constexpr Index kNone = -1;

/// A point or vector in world units of the control asset.
using Vec3 = Eigen::Vector3d;

}  // namespace octet
