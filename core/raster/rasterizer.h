// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/context.h"
#include "../field/piece_source.h"
#include "tile.h"

namespace octet {

/// @brief Samples a field on a grid, tile by tile, in parallel: cells are binned to the tiles they
/// meet, and every tile is filled by one task, cells in ascending order, so that the result does
/// not depend on threads.
///
/// @param sink  called once per tile with at least one active sample, from any thread, in no
///              particular order
/// @param context  told of blocks of tiles from the calling thread, polled from all
/// @throws InputError when the grid needs indices beyond 2^30, Cancelled
template <int C>
void rasterize(const PieceSource<C>& source, const GridFrame& frame, Sampling sampling,
               const TileSink<C>& sink, const std::string& stage = "", const Context& context = {});

}  // namespace octet
