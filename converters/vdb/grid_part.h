// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <octet/core/raster/tile.h>

#include "metadata.h"

namespace octet {

/// One of several parts of about equal work; together they are the whole.
struct Shard {
  int number = 1, count = 1;  ///< number from 1
};

/// What a grid is of a bake that it is not the whole of.
struct GridPart {
  std::optional<Shard> shard;  ///< none: a region
  std::string bake;            ///< tag of the whole: parts of one bake have the same
  IndexBox window;             ///< the tiles that it was baked for; may be empty
};

/// Says which part: "shard 2 of 7", "region".
std::string partName(const GridPart& part);

/// All names of metadata about parts begin with this.
inline constexpr const char* kPartMetadata = "octet_part";
std::vector<VdbMetadata> toMetadata(const GridPart& part);
/// Reads what toMetadata() made; nothing of a grid that is a whole.
/// @param text  gives the value of a metadatum, empty when there is none
/// @throws InputError when it makes no sense
std::optional<GridPart> readPart(const std::function<std::string(const std::string&)>& text);

/// Do windows cover all tiles, each once?
bool coverAll(const std::vector<IndexBox>& windows);

}  // namespace octet
