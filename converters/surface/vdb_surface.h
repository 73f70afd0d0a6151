// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include <octet/core/cage/lattice_fill.h>

#include "read_surface.h"

namespace octet {

/// The surface of a scalar grid of a .vdb; see readSurface.
TriangleSurface readVdbSurface(const std::string& path, const SurfaceReadOptions& options);

/// @brief Signed distance to a closed surface, sampled by OpenVDB's meshToVolume on voxels of the
/// given size: exact to a fraction of a voxel within `band` of the surface, beyond it the band's
/// width with the right sign. Whether a point is inside is OpenVDB's: what cannot be reached from
/// outside without crossing the surface; triangles may have any orientation and intersect.
/// @throws Cancelled
SignedDistance sampledDistance(const TriangleSurface& surface, double voxelSize, double band,
                               const Context& context = {});

}  // namespace octet
