// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "../base/types.h"

namespace octet {

/// A uniform grid: sample ijk lies at origin + voxelSize * (i, j, k), world units.
struct GridFrame {
  Vec3 origin = Vec3::Zero();
  double voxelSize = 1;
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
};

/// Takes tiles, each once.
template <int C>
using TileSink = std::function<void(const Tile<C>&)>;

}  // namespace octet
