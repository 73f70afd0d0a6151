// SPDX-License-Identifier: Apache-2.0
#include "bake_part.h"

#include <cmath>

#include <octet/core/raster/block_bins.h>

namespace octet {
namespace {

constexpr int kTile = Tile<1>::kWidth;
/// A part may be larger for the sake of patches by one in so many.
constexpr int kNear = 16;

/// The tile whose samples are nearest to a place along an axis.
GridIndex tileAt(double x, double voxelSize) {
  const double tile = std::floor((x / voxelSize + 0.5) / kTile);
  return static_cast<GridIndex>(std::clamp<double>(tile, -kTileLimit, kTileLimit - 1));
}

/// Where a tile begins: between its first sample and the one before.
double beginOf(GridIndex tile, double voxelSize) { return (tile * kTile - 0.5) * voxelSize; }

Box boxOf(const IndexBox& tiles, double voxelSize) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = beginOf(tiles.min[k], voxelSize);
    box.max[k] = beginOf(tiles.max[k] + 1, voxelSize);
  }
  return box;
}

IndexBox tilesOf(const Box& box, double voxelSize) {
  IndexBox tiles;
  for (int k = 0; k < 3; ++k) {
    tiles.min[k] = tileAt(box.min[k], voxelSize);
    tiles.max[k] = tileAt(box.max[k], voxelSize);
  }
  return tiles;
}

IndexBox regionWindow(const Box& region, const MeshFacts& facts, double voxelSize) {
  if (!region.min.allFinite() || !region.max.allFinite()) {
    throw InputError("region", "is not finite");
  }
  if (region.empty()) throw InputError("region", "is empty: its first corner is not the lower one");
  const Box turned = turnedBox(region, facts.turn);
  const IndexBox window = tilesOf(turned, voxelSize);
  if (intersection(window, tilesOf(facts.domain.box(), voxelSize)).empty()) {
    throw InputError("region", "lies outside the domain");
  }
  return window;
}

/// Cuts the domain across its longest side, and the halves again, so that all parts have about the
/// same volume. What is beyond the domain goes with the part beside it.
IndexBox shardWindow(const Shard& shard, const DomainShape& domain, double voxelSize) {
  IndexBox window = kAllTiles, brick = tilesOf(domain.box(), voxelSize);
  const std::array<GridIndex, 3> first = brick.min;
  int number = shard.number - 1;
  for (int count = shard.count; count > 1;) {
    int axis = 0;
    for (int k = 1; k < 3; ++k) {
      if (brick.max[k] - brick.min[k] > brick.max[axis] - brick.min[axis]) axis = k;
    }
    const int below = count / 2;
    const GridIndex from = brick.min[axis], to = brick.max[axis];
    if (from == to) {  // nothing left to cut: the first part has it all
      if (number > 0) return {{0, 0, 0}, {-1, -1, -1}};
      return window;
    }
    const double place =
        domain.cut(boxOf(brick, voxelSize), axis, static_cast<double>(below) / count);
    const double tiles = (place / voxelSize + 0.5) / kTile - first[axis];
    GridIndex cut = first[axis] + static_cast<GridIndex>(std::lround(tiles));
    // Where a patch begins, so that none is painted for two parts, when that is near.
    const GridIndex patch =
        first[axis] + kPatchTiles * static_cast<GridIndex>(std::lround(tiles / kPatchTiles));
    if (kNear * std::abs(patch - cut) <= to - from) cut = patch;
    cut = std::clamp(cut, from + 1, to);
    if (number < below) {
      window.max[axis] = brick.max[axis] = cut - 1;
      count = below;
    } else {
      window.min[axis] = brick.min[axis] = cut;
      number -= below;
      count -= below;
    }
  }
  return window;
}

}  // namespace

IndexBox bakeWindow(const BakeOptions& options, const MeshFacts& facts, double voxelSize) {
  if (options.region && options.shard) {
    throw InputError("shard", "goes without a region: shards are parts of the whole");
  }
  if (options.region) return regionWindow(*options.region, facts, voxelSize);
  if (!options.shard) return kAllTiles;
  if (options.shard->count < 1 || options.shard->number < 1 ||
      options.shard->number > options.shard->count) {
    throw InputError("shard", std::to_string(options.shard->number) + "/" +
                                  std::to_string(options.shard->count) +
                                  " is none: the first of N is 1/N, the last N/N");
  }
  return shardWindow(*options.shard, facts.domain, voxelSize);
}

BakePart::BakePart(const BakeOptions& options, const MeshFacts& facts,
                   const ResolutionPlan& resolution) {
  const IndexBox window = bakeWindow(options, facts, resolution.voxelSize);
  if (options.region || options.shard) part_ = GridPart{options.shard, "", window};
}

std::optional<GridPart> BakePart::at(const std::string& tag) const {
  std::optional<GridPart> part = part_;
  if (part) part->bake = tag;
  return part;
}

}  // namespace octet
