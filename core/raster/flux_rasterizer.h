// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/context.h"
#include "../hodge/potential_field.h"
#include "tile.h"

namespace octet {

/// @brief Velocities of a staggered grid whose discrete divergence is zero: mean fluxes of d A
/// through the faces of voxels, each the circulation of A around its four sides (SCHEME.md section
/// 9). The integral along a side is exact, piece by piece, so a mean is that of the continuous
/// velocity; and whatever is left of rounding, a side has one value, so the fluxes out of a voxel
/// cancel: component c at ijk is the mean over the voxel face at ijk - 1/2 along c, and the forward
/// differences u(i+1) - u(i) are a voxel's outflow.
/// - A zero on the boundary: it is continued by zero, so that faces cut by a wall carry the flux of
///   their inner part. Active is every voxel that the domain touches, and the next one on the +
///   sides, so that the operator reads active voxels only.
/// - else: only faces wholly inside have a value; active is every voxel wholly inside. Its faces on
///   the + sides are stored with voxels that may be inactive.
///
/// @param sink  called once per tile with an active sample or a value, from any thread, in no
///              particular order; the same tiles for any number of threads
/// @throws InputError, Cancelled as rasterize()
void rasterizeFluxes(const PotentialField& field, const GridFrame& frame, const TileSink<3>& sink,
                     const std::string& stage = "", const Context& context = {});

/// @brief The same for a collocated grid and central differences: component c at ijk is the mean
/// over the square of 2 x 2 voxels around ijk across c, and of these means, which cancel around
/// every voxel, the mean of a voxel and its six neighbours. Active is every voxel for which all
/// these squares lie inside.
/// @param neighbours  weight of each neighbour: 0 to 1/6
void rasterizeMeanFluxes(const PotentialField& field, const GridFrame& frame, double neighbours,
                         const TileSink<3>& sink, const std::string& stage = "",
                         const Context& context = {});

/// @brief The weight with which mean fluxes are nearest to the limit of refinement.
///
/// Coefficients of a level are to their limit as control points are to a spline: the limit is
/// smoother. On the lattice it differs from the level's own field by a ninth of an edge squared
/// times its Laplacian, and a mean over squares by 2/15 of a voxel squared; neighbours make up for
/// the difference. Irregular cells need less; half of it serves both
/// (samples/conservation/README.md).
/// @param voxelsPerEdge  voxel size over mean fine edge
double neighbourWeight(double voxelsPerEdge);

/// Between these sizes of voxels, in mean fine edges, mean fluxes are at least as near to the limit
/// as samples are, in the root mean square, as measured (samples/conservation/README.md).
inline constexpr double kFinestMeans = 0.3, kCoarsestMeans = 0.75;

}  // namespace octet
