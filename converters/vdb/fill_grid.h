// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include <openvdb/openvdb.h>

#include <octet/core/raster/rasterizer.h>

#include "vdb_file.h"

/// @file
/// For the sources of this folder alone: it brings OpenVDB's headers.

namespace octet {

/// Calls its argument with the tiles of a grid, each once, from any thread.
template <int C>
using TileSource = std::function<void(const std::function<void(const Tile<C>&)>&)>;

/// A grid of tiles, as a file stores their values: rounded to 16-bit floats if the spec says so.
/// Instantiated for FloatGrid and Vec3SGrid.
/// @throws InputError for values that the file's floats do not hold
template <typename Grid, int C>
typename Grid::Ptr fillGrid(const TileSource<C>& tiles, const VdbGridSpec& spec);

/// Replaces values of a grid's active voxels by the active samples of tiles; what is active stays.
/// @return how many voxels
/// @throws InputError as fillGrid()
std::uint64_t replaceValues(const TileSource<3>& tiles, const VdbGridSpec& spec,
                            openvdb::Vec3SGrid* grid);

}  // namespace octet
