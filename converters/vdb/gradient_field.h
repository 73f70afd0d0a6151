// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include <octet/core/field/field.h>
#include <octet/core/field/rasterizer.h>

namespace octet {

/// @brief A potential f whose gradient is second-order accurate (SCHEME.md section 9): with limit
/// values f_i, limit vectors V_i and barycentric coordinates l_i, f(x) = sum l_i (f_i + V_i . (x -
/// x_i) / 2), which reproduces quadratic functions. It is the sum of two fields that are linear in
/// pieces: f(x) = base(x) + x . vectors(x) / 2.
struct GradientField {
  ScalarField base;     ///< f_i - V_i . x_i / 2
  VectorField vectors;  ///< V_i
};

/// Differences of f between voxels' centres: curl-free for backward differences on a staggered grid
/// and for central ones on a collocated grid, whatever f is. Outside the domain f is continued by
/// one voxel from the vectors. Active is every voxel whose centre lies inside.
/// @param sink  called once per tile with an active sample, from the calling thread
/// @throws InputError, Cancelled as rasterize()
void rasterizeDifferences(const GradientField& field, const GridFrame& frame, Sampling sampling,
                          const std::function<void(const Tile<3>&)>& sink, const std::string& stage,
                          const ProgressCallback& progress);

}  // namespace octet
