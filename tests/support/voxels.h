// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <mutex>

#include <octet/core/raster/rasterizer.h>

namespace octet::testing {

using Ijk = std::array<std::int32_t, 3>;
using VoxelValues = std::map<Ijk, Vec3>;

/// The active voxels of what `rasterizeTo(sink)` makes.
template <typename Rasterize>
VoxelValues activeVoxels(const Rasterize& rasterizeTo) {
  VoxelValues values;
  std::mutex mutex;
  rasterizeTo([&](const Tile<3>& tile) {
    const std::lock_guard<std::mutex> lock(mutex);
    for (int n = 0; n < Tile<3>::kSize; ++n) {
      if (!tile.isActive(n)) continue;
      values[{tile.origin[0] + n / 64, tile.origin[1] + n / 8 % 8, tile.origin[2] + n % 8}] =
          Vec3(tile.values[0][n], tile.values[1][n], tile.values[2][n]);
    }
  });
  return values;
}

}  // namespace octet::testing
