// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../field/rasterizer.h"
#include "potential_field.h"

namespace octet {

/// @brief Velocities whose discrete divergence is zero: mean fluxes of d A through squares of a
/// grid, each the circulation of A around its four sides (scheme.md section 9). The integral along
/// a side is exact, piece by piece, so a mean is that of the continuous velocity; and whatever is
/// left of rounding, a side has one value, so the fluxes out of a voxel cancel.
///
/// Staggered: component c at ijk is the mean over the voxel face at ijk - 1/2 along c. The forward
/// differences u(i+1) - u(i) are then a voxel's outflow.
/// - A zero on the boundary: it is continued by zero, so that faces cut by a wall carry the flux of
///   their inner part. Active is every voxel that the domain touches, and the next one on the +
///   sides, so that the operator reads active voxels only.
/// - else: only faces wholly inside have a value; active is every voxel wholly inside. Its faces on
///   the + sides are stored with voxels that may be inactive.
///
/// Collocated: component c at ijk is the mean over the square of 2 x 2 voxels around ijk across c:
/// then central differences cancel. Active is every voxel with three squares wholly inside.
///
/// @param sink  called once per tile with an active sample or a value, from any thread, in no
///              particular order; the same tiles for any number of threads
/// @throws InputError, Cancelled as rasterize()
void rasterizeFluxes(const PotentialField& field, const GridFrame& frame, Sampling sampling,
                     const std::function<void(const Tile<3>&)>& sink, const std::string& stage = "",
                     const ProgressCallback& progress = {});

}  // namespace octet
