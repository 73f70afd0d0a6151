// SPDX-License-Identifier: Apache-2.0
#include "fill_grid.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>

#include <openvdb/io/Compression.h>
#include <tbb/enumerable_thread_specific.h>

namespace octet {
namespace {

/// The value of a sample as a file stores it.
template <typename Value, int C>
Value gridValue(const Tile<C>& tile, int n, bool half) {
  Value value;
  if constexpr (C == 1) {
    value = static_cast<Value>(tile.values[0][n]);
  } else {
    value = Value(static_cast<float>(tile.values[0][n]), static_cast<float>(tile.values[1][n]),
                  static_cast<float>(tile.values[2][n]));
  }
  return half ? openvdb::io::truncateRealToHalf(value) : value;
}

/// Keeps the larger absolute value; unlike std::max, also what is not a number.
void keepLargest(double* largest, float x) {
  const double size = std::abs(x);
  if (!std::isnan(*largest) && !(size <= *largest)) *largest = size;
}
void keepLargest(double* largest, const openvdb::Vec3f& v) {
  for (int k = 0; k < 3; ++k) keepLargest(largest, v[k]);
}

constexpr double kLargestHalf = 65504;

void checkRange(const VdbGridSpec& spec, double largest) {
  const double most = spec.half ? kLargestHalf : std::numeric_limits<float>::max();
  if (largest <= most) return;
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", largest);
  throw InputError(
      "grid \"" + spec.name + "\"",
      "has values up to " + std::string(text) + ", more than " +
          (spec.half ? "16-bit floats hold (65504); bake it without half" : "32-bit floats hold"));
}

openvdb::Coord originOf(const std::array<std::int32_t, 3>& origin) {
  return {origin[0], origin[1], origin[2]};
}

/// Leaves made by one thread.
template <typename Leaf>
struct LeafBatch {
  std::vector<std::unique_ptr<Leaf>> leaves;
  double largest = 0;
};

}  // namespace

template <typename Grid, int C>
typename Grid::Ptr fillGrid(const TileSource<C>& tiles, const VdbGridSpec& spec) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  using Value = typename Grid::ValueType;
  tbb::enumerable_thread_specific<LeafBatch<Leaf>> batches;
  tiles([&](const Tile<C>& tile) {
    LeafBatch<Leaf>& batch = batches.local();
    auto leaf = std::make_unique<Leaf>(originOf(tile.origin), Value(0.0f), false);
    Value* out = leaf->buffer().data();
    for (int n = 0; n < Tile<C>::kSize; ++n) {
      out[n] = gridValue<Value>(tile, n, spec.half);
      if (tile.isActive(n)) keepLargest(&batch.largest, out[n]);
    }
    typename Leaf::NodeMaskType mask;
    for (int x = 0; x < 8; ++x) mask.template getWord<openvdb::Index64>(x) = tile.active[x];
    leaf->setValueMask(mask);
    batch.leaves.push_back(std::move(leaf));
  });
  auto grid = Grid::create(Value(0.0f));
  for (LeafBatch<Leaf>& batch : batches) {
    checkRange(spec, batch.largest);
    for (auto& leaf : batch.leaves) grid->tree().addLeaf(leaf.release());
  }
  return grid;
}

template openvdb::FloatGrid::Ptr fillGrid<openvdb::FloatGrid, 1>(const TileSource<1>&,
                                                                 const VdbGridSpec&);
template openvdb::Vec3SGrid::Ptr fillGrid<openvdb::Vec3SGrid, 3>(const TileSource<3>&,
                                                                 const VdbGridSpec&);

std::uint64_t replaceValues(const TileSource<3>& tiles, const VdbGridSpec& spec,
                            openvdb::Vec3SGrid* grid) {
  std::atomic<std::uint64_t> count{0};
  tbb::enumerable_thread_specific<double> largest(0.0);
  tiles([&](const Tile<3>& tile) {
    // No two tiles share a leaf.
    auto* const leaf = grid->tree().probeLeaf(originOf(tile.origin));
    if (!leaf) return;
    std::uint64_t replaced = 0;
    for (int n = 0; n < Tile<3>::kSize; ++n) {
      if (!tile.isActive(n) || !leaf->isValueOn(static_cast<openvdb::Index>(n))) continue;
      const auto value = gridValue<openvdb::Vec3f>(tile, n, spec.half);
      keepLargest(&largest.local(), value);
      leaf->setValueOnly(static_cast<openvdb::Index>(n), value);
      ++replaced;
    }
    count += replaced;
  });
  for (const double each : largest) checkRange(spec, each);
  return count;
}

}  // namespace octet
