// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "../base/context.h"
#include "../field/gradient_field.h"
#include "tile.h"

namespace octet {

/// Samples differences of f between voxels' centres: curl-free for backward differences on a
/// staggered grid and for central ones on a collocated grid, whatever f is. Outside the domain f is
/// continued by one voxel from the vectors. Active is every voxel whose centre lies inside.
/// @param sink  called once per tile with an active sample, from any thread
/// @throws InputError, Cancelled as rasterize()
void rasterizeDifferences(const GradientField& field, const GridFrame& frame, Sampling sampling,
                          const TileSink<3>& sink, const std::string& stage,
                          const Context& context);

}  // namespace octet
