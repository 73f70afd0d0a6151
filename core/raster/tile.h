// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

#include "../base/types.h"

namespace octet {

/// Index of a sample or a tile.
using GridIndex = std::int32_t;

/// A range of integer points, both ends included.
struct IndexBox {
  std::array<GridIndex, 3> min, max;
  bool empty() const { return min[0] > max[0] || min[1] > max[1] || min[2] > max[2]; }
  bool contains(const std::array<GridIndex, 3>& at) const {
    for (int k = 0; k < 3; ++k) {
      if (at[k] < min[k] || at[k] > max[k]) return false;
    }
    return true;
  }
};

/// What two ranges have in common.
inline IndexBox intersection(const IndexBox& a, const IndexBox& b) {
  IndexBox both = a;
  for (int k = 0; k < 3; ++k) {
    both.min[k] = std::max(a.min[k], b.min[k]);
    both.max[k] = std::min(a.max[k], b.max[k]);
  }
  return both;
}

/// More tiles than a grid can have: indices of samples stay below 2^30.
inline constexpr GridIndex kTileLimit = 1 << 27;
inline constexpr IndexBox kAllTiles{{-kTileLimit, -kTileLimit, -kTileLimit},
                                    {kTileLimit - 1, kTileLimit - 1, kTileLimit - 1}};

/// A uniform grid: sample ijk lies at origin + voxelSize * (i, j, k), world units.
struct GridFrame {
  Vec3 origin = Vec3::Zero();
  double voxelSize = 1;
  IndexBox window = kAllTiles;  ///< the tiles that are wanted; no value depends on it
};

/// Where a vector's components are sampled.
enum class Sampling : std::uint8_t {
  Collocated,  ///< all at ijk
  Staggered,   ///< x at (i-1/2, j, k), y at (i, j-1/2, k), z at (i, j, k-1/2)
};

/// @brief 8 x 8 x 8 samples, in the order of an OpenVDB leaf: (x * 8 + y) * 8 + z. Components of
/// inactive samples are 0; a staggered sample is active when any of its components is.
template <int C>
struct Tile {
  static constexpr int kWidth = 8, kSize = 512;
  std::array<std::int32_t, 3> origin;  ///< of its first sample, multiples of 8
  std::array<std::array<double, kSize>, C> values;
  std::array<std::uint64_t, 8> active;  ///< bit y * 8 + z of word x

  bool isActive(int n) const { return active[n >> 6] >> (n & 63) & 1u; }
  /// Its place among tiles.
  std::array<GridIndex, 3> place() const {
    return {origin[0] >> 3, origin[1] >> 3, origin[2] >> 3};
  }
};

/// Takes tiles, each once.
template <int C>
using TileSink = std::function<void(const Tile<C>&)>;

}  // namespace octet
