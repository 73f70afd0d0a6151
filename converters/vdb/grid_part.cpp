// SPDX-License-Identifier: Apache-2.0
#include "grid_part.h"

#include <sstream>

#include <octet/core/base/error.h>

namespace octet {
namespace {

const std::string kName = kPartMetadata, kBake = kName + "_of", kWindow = kName + "_window";

/// Tiles of a window, once its open ends are drawn to where others end.
std::int64_t tileCount(const IndexBox& box) {
  std::int64_t count = 1;
  for (int k = 0; k < 3; ++k) {
    count *= std::max<std::int64_t>(0, std::int64_t{box.max[k]} - box.min[k] + 1);
  }
  return count;
}

/// The tiles from the lowest to the highest where a window begins or ends, and one on either side.
IndexBox whereSomeEnd(const std::vector<IndexBox>& windows) {
  IndexBox box{{0, 0, 0}, {0, 0, 0}};
  for (const IndexBox& window : windows) {
    if (window.empty()) continue;
    for (int k = 0; k < 3; ++k) {
      for (const GridIndex end : {window.min[k], window.max[k]}) {
        if (end == kAllTiles.min[k] || end == kAllTiles.max[k]) continue;
        box.min[k] = std::min(box.min[k], end);
        box.max[k] = std::max(box.max[k], end);
      }
    }
  }
  for (int k = 0; k < 3; ++k) {
    --box.min[k];
    ++box.max[k];
  }
  return box;
}

}  // namespace

std::string partName(const GridPart& part) {
  if (!part.shard) return "region";
  return "shard " + std::to_string(part.shard->number) + " of " + std::to_string(part.shard->count);
}

std::vector<VdbMetadata> toMetadata(const GridPart& part) {
  std::string window;
  for (const auto& corner : {part.window.min, part.window.max}) {
    for (const GridIndex tile : corner) {
      window += (window.empty() ? "" : " ") + std::to_string(tile);
    }
  }
  return {{kName, partName(part)}, {kBake, part.bake}, {kWindow, window}};
}

std::optional<GridPart> readPart(const std::function<std::string(const std::string&)>& text) {
  const std::string name = text(kName);
  if (name.empty()) return std::nullopt;
  GridPart part;
  part.bake = text(kBake);
  std::string shard, of;
  Shard numbers;
  if (std::istringstream(name) >> shard >> numbers.number >> of >> numbers.count) {
    part.shard = numbers;
  }
  std::istringstream window(text(kWindow));
  for (auto* corner : {&part.window.min, &part.window.max}) {
    for (GridIndex& tile : *corner) window >> tile;
  }
  if (!window || partName(part) != name) {
    throw InputError("", "what it says of the part that it is makes no sense");
  }
  return part;
}

bool coverAll(const std::vector<IndexBox>& windows) {
  const IndexBox box = whereSomeEnd(windows);
  std::int64_t count = 0;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    count += tileCount(intersection(windows[k], box));
    for (std::size_t other = 0; other < k; ++other) {
      if (!intersection(windows[k], windows[other]).empty()) return false;
    }
  }
  return count == tileCount(box);
}

}  // namespace octet
