// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <functional>

#include "../base/parallel.h"
#include "tile.h"

namespace octet {

inline GridIndex floorDivide(GridIndex a, GridIndex b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/// A patch is what is painted at once, this many tiles wide: so large that few cells lie in several
/// patches, so small that it stays in a second-level cache.
inline constexpr int kPatchTiles = 4;

/// Cells by the blocks of patches that they meet, ascending in each.
class BlockBins {
 public:
  /// @param tiles  to cover, from the first of them on; cells may reach beyond
  BlockBins(Index cellCount, const IndexBox& tiles,
            const std::function<IndexBox(Index)>& tilesOfCell)
      : tilesOfCell_(tilesOfCell), tiles_(tiles), first_(tiles.min) {
    for (width_ = kPatchTiles; blockCount(tiles) > kMostBlocks; width_ *= 2) {
    }
    for (int k = 0; k < 3; ++k) counts_[k] = (tiles.max[k] - tiles.min[k]) / width_ + 1;
    // A fixed number of chunks counts and then fills in parallel; their order keeps cells sorted.
    const std::size_t blocks = static_cast<std::size_t>(blockCount(tiles));
    const int chunks = static_cast<int>(std::clamp<std::size_t>(
        (std::size_t{1} << 24) / blocks, 1, std::min<std::size_t>(64, cellCount / 4096 + 1)));
    Array<std::size_t> next(blocks * chunks + 1, 0);
    const auto chunkLoop = [&](const auto& body) {
      parallelFor<int>(
          chunks,
          [&](int chunk) {
            const auto bound = [&](int k) {
              return static_cast<Index>(std::int64_t{cellCount} * k / chunks);
            };
            for (Index cell = bound(chunk); cell < bound(chunk + 1); ++cell) {
              visitBlocks(cell, [&](std::size_t b) { body(b * chunks + chunk, cell); });
            }
          },
          1);
    };
    chunkLoop([&](std::size_t slot, Index) { ++next[slot + 1]; });
    for (std::size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
    begin_.resize(blocks + 1);
    for (std::size_t b = 0; b <= blocks; ++b) begin_[b] = next[b * chunks];
    items_.resize(next.back());
    chunkLoop([&](std::size_t slot, Index cell) { items_[next[slot]++] = cell; });
  }

  std::size_t blockCount() const { return begin_.size() - 1; }
  const Index* begin(std::size_t block) const { return items_.data() + begin_[block]; }
  const Index* end(std::size_t block) const { return items_.data() + begin_[block + 1]; }

  /// Calls `visit` with the first tile of each patch of a block.
  template <typename Visit>
  void visitPatches(std::size_t block, const Visit& visit) const {
    const std::size_t perLayer = static_cast<std::size_t>(counts_[1]) * counts_[2];
    const GridIndex at[3] = {static_cast<GridIndex>(block / perLayer),
                             static_cast<GridIndex>(block % perLayer / counts_[2]),
                             static_cast<GridIndex>(block % counts_[2])};
    for (GridIndex i = 0; i < width_; i += kPatchTiles) {
      for (GridIndex j = 0; j < width_; j += kPatchTiles) {
        for (GridIndex k = 0; k < width_; k += kPatchTiles) {
          visit(std::array<GridIndex, 3>{first_[0] + at[0] * width_ + i,
                                         first_[1] + at[1] * width_ + j,
                                         first_[2] + at[2] * width_ + k});
        }
      }
    }
  }

 private:
  std::int64_t blockCount(const IndexBox& tiles) const {
    std::int64_t n = 1;
    for (int k = 0; k < 3; ++k) n *= (tiles.max[k] - tiles.min[k]) / width_ + 1;
    return n;
  }

  template <typename Visit>
  void visitBlocks(Index cell, const Visit& visit) const {
    const IndexBox box = intersection(tilesOfCell_(cell), tiles_);
    if (box.empty()) return;
    const auto block = [&](GridIndex tile, int k) { return (tile - first_[k]) / width_; };
    for (GridIndex i = block(box.min[0], 0); i <= block(box.max[0], 0); ++i) {
      for (GridIndex j = block(box.min[1], 1); j <= block(box.max[1], 1); ++j) {
        for (GridIndex k = block(box.min[2], 2); k <= block(box.max[2], 2); ++k) {
          visit((static_cast<std::size_t>(i) * counts_[1] + j) * counts_[2] + k);
        }
      }
    }
  }

  std::function<IndexBox(Index)> tilesOfCell_;
  const IndexBox tiles_;
  /// Blocks are one patch each, unless that makes more of them than this.
  static constexpr std::int64_t kMostBlocks = 1 << 20;

  std::array<GridIndex, 3> first_;
  std::array<GridIndex, 3> counts_{};
  GridIndex width_ = kPatchTiles;
  Array<std::size_t> begin_;
  Array<Index> items_;
};

}  // namespace octet
