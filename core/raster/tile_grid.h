// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "tile.h"

namespace octet {

/// Index of a sample.
using SampleIndex = std::array<std::int32_t, 3>;

/// @brief A sparse grid of tiles in memory, for what needs neighbours. Samples are found by their
/// index. Adding tiles is thread safe; writing values is not.
template <int C>
class TileGrid {
 public:
  /// Adds a tile where there is none.
  void add(const Tile<C>& tile) {
    const std::lock_guard<std::mutex> lock(mutex_);
    places_.emplace(tile.origin, tiles_.size());
    tiles_.push_back(std::make_unique<Tile<C>>(tile));
  }

  /// Puts tiles into an order that does not depend on when they were added: that of an OpenVDB
  /// tree, by blocks of 4096, then 128, then 8 samples.
  void sort() {
    const auto before = [](const auto& a, const auto& b) {
      for (const int bits : {12, 7, 3}) {
        for (int k = 0; k < 3; ++k) {
          const std::int32_t i = a->origin[k] >> bits, j = b->origin[k] >> bits;
          if (i != j) return i < j;
        }
      }
      return false;
    };
    std::sort(tiles_.begin(), tiles_.end(), before);
    for (std::size_t t = 0; t < tiles_.size(); ++t) places_[tiles_[t]->origin] = t;
  }

  std::size_t tileCount() const { return tiles_.size(); }
  const Tile<C>& tile(std::size_t t) const { return *tiles_[t]; }
  Tile<C>& tile(std::size_t t) { return *tiles_[t]; }

  /// The tile that a sample lies in, or null.
  const Tile<C>* find(const SampleIndex& at) const {
    const auto place = places_.find(originOf(at));
    return place == places_.end() ? nullptr : tiles_[place->second].get();
  }
  /// The same; makes a tile of zeros, nothing active, when there is none.
  Tile<C>& at(const SampleIndex& at) {
    const SampleIndex origin = originOf(at);
    const auto [place, isNew] = places_.emplace(origin, tiles_.size());
    if (isNew) {
      tiles_.push_back(std::make_unique<Tile<C>>());
      Tile<C>& tile = *tiles_.back();
      tile.origin = origin;
      tile.active.fill(0);
      for (auto& component : tile.values) component.fill(0);
    }
    return *tiles_[place->second];
  }

 private:
  struct Hash {
    std::size_t operator()(const SampleIndex& i) const {
      std::uint64_t h = 0;
      for (const std::int32_t x : i) {
        h = (h ^ static_cast<std::uint32_t>(x >> 3)) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
      }
      return static_cast<std::size_t>(h);
    }
  };

  static SampleIndex originOf(const SampleIndex& at) {
    return {at[0] & ~7, at[1] & ~7, at[2] & ~7};
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<Tile<C>>> tiles_;
  std::unordered_map<SampleIndex, std::size_t, Hash> places_;
};

/// Place of a sample in its tile.
inline int placeInTile(const SampleIndex& at) {
  return ((at[0] & 7) * 8 + (at[1] & 7)) * 8 + (at[2] & 7);
}

/// Calls visit(index of a sample, its place in the tile) for the active samples of a tile.
template <int C, typename Visit>
void visitActive(const Tile<C>& tile, const Visit& visit) {
  for (int n = 0; n < Tile<C>::kSize; ++n) {
    if (!tile.isActive(n)) continue;
    visit(SampleIndex{tile.origin[0] + (n >> 6), tile.origin[1] + (n >> 3 & 7),
                      tile.origin[2] + (n & 7)},
          n);
  }
}

}  // namespace octet
