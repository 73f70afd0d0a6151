// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/context.h"
#include "../geometry/box_bins.h"
#include "../topology/control_mesh.h"

namespace octet {

/// Most cells a fill makes: about 60 GB of control mesh, above which a spacing is a slip.
inline constexpr std::int64_t kMostCageCells = 40'000'000;

/// @brief A box filled with the regular lattice of tetrahedra and octahedra, whose walls are
/// exactly flat, with creases along its twelve edges.
///
/// *Every* interior vertex is regular (type R), so inside the box the flow is exactly the thesis'
/// smooth scheme. At a wall the lattice's octahedra stick out by half; instead of cutting them into
/// tetrahedra, which would make the first interior layer irregular, their outer pole is put into
/// the wall. (Six tetrahedra a cube, the usual way, has no regular vertex at all.) Along the
/// box' edges the quarters of octahedra are tetrahedra; corners are lattice vertices.
///
/// @param spacing  edge length of the lattice wanted; it is stretched along each axis so that a
/// whole and even number of layers, at least 2, fits.
/// @throws InputError for an empty or non-finite box, a spacing that is not positive, and more than
/// kMostCageCells cells.
ControlMeshInput boxCage(const Box& box, double spacing);

}  // namespace octet
