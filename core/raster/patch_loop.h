// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <tbb/enumerable_thread_specific.h>

#include "../base/error.h"
#include "../base/reported_loop.h"
#include "block_bins.h"
#include "tile.h"

namespace octet {

/// Samples along a patch.
inline constexpr int kPatchSamples = kPatchTiles * Tile<1>::kWidth;

/// @throws InputError
inline void checkVoxelSize(const GridFrame& frame) {
  if (frame.voxelSize > 0 && std::isfinite(frame.voxelSize)) return;
  throw InputError("voxel size", "is not a positive number");
}

/// A point in voxels: the index of a sample that lies there.
inline Vec3 inVoxels(const Vec3& point, const GridFrame& frame) {
  return (point - frame.origin) / frame.voxelSize;
}

/// The tiles of a range of samples, which may be empty.
/// @param first, last  whole numbers
/// @throws InputError for indices beyond 2^30
inline IndexBox tilesOfSamples(const Vec3& first, const Vec3& last) {
  constexpr double kLargestIndex = 1 << 30;
  IndexBox tiles;
  for (int k = 0; k < 3; ++k) {
    if (!(std::abs(first[k]) < kLargestIndex && std::abs(last[k]) < kLargestIndex)) {
      throw InputError("voxel size", "is so small that the grid needs more than 2^30 voxels");
    }
    const auto from = static_cast<GridIndex>(first[k]), to = static_cast<GridIndex>(last[k]);
    tiles.min[k] = floorDivide(from, Tile<1>::kWidth);
    tiles.max[k] = from > to ? tiles.min[k] - 1 : floorDivide(to, Tile<1>::kWidth);
  }
  return tiles;
}

/// Which tiles which cells meet.
struct CellTiles {
  Index cellCount;
  IndexBox all;  ///< the tiles of all cells
  std::function<IndexBox(Index)> ofCell;
  IndexBox window = kAllTiles;  ///< the tiles that are wanted

  /// What is wanted of all, made larger so that it begins where a patch of all begins.
  IndexBox wanted() const {
    IndexBox tiles = intersection(all, window);
    if (tiles.empty()) return tiles;
    for (int k = 0; k < 3; ++k) tiles.min[k] -= (tiles.min[k] - all.min[k]) % kPatchTiles;
    return tiles;
  }
};

/// @brief Fills a grid patch by patch, in parallel. A patch is filled by one task, from its cells
/// in ascending order, so that the result does not depend on threads. Patches lie as those of all
/// tiles do, so that neither does it depend on the window.
///
/// Whatever rasterises is a Patch: begin(first tile) clears it, paint(cell) takes what a cell adds,
/// finish(sink) hands out its tiles.
/// @param makePatch  makes one for each thread that needs it
/// @param context  told of blocks from the calling thread, polled from all
template <int C, typename MakePatch>
void fillPatches(const CellTiles& cells, const MakePatch& makePatch, const TileSink<C>& sink,
                 const std::string& stage, const Context& context) {
  const IndexBox wanted = cells.wanted();
  if (wanted.empty()) return;
  const BlockBins blocks(cells.cellCount, wanted, cells.ofCell);
  tbb::enumerable_thread_specific<decltype(makePatch())> patches(makePatch);
  const TileSink<C> inWindow = [&](const Tile<C>& tile) {
    if (cells.window.contains(tile.place())) sink(tile);
  };
  const auto fillBlock = [&](std::size_t block) {
    if (blocks.begin(block) == blocks.end(block)) return;
    auto& patch = patches.local();
    blocks.visitPatches(block, [&](const std::array<GridIndex, 3>& tile) {
      IndexBox tiles{tile, tile};
      for (GridIndex& last : tiles.max) last += kPatchTiles - 1;
      if (intersection(tiles, wanted).empty()) return;
      patch.begin(tile);
      for (const Index* cell = blocks.begin(block); cell != blocks.end(block); ++cell) {
        patch.paint(*cell);
      }
      patch.finish(inWindow);
    });
  };
  // Progress is reported about this often, and for no fewer blocks at once than these.
  constexpr std::size_t kReports = 100, kFewestBlocks = 256;
  const std::size_t count = blocks.blockCount();
  const std::size_t atOnce = std::max(kFewestBlocks, count / kReports);
  for (std::size_t first = 0; first < count; first += atOnce) {
    context.report({stage, first, count, "blocks"});
    parallelFor<std::size_t>(
        std::min(atOnce, count - first), [&](std::size_t k) { fillBlock(first + k); }, context, 1);
  }
  context.report({stage, count, count, "blocks"});
}

}  // namespace octet
