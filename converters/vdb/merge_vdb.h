// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake.h"

namespace octet {

/// @brief Joins the shards of a bake to the whole: the file that the bake would have made without
/// shards, to the byte, with certificates measured anew.
/// @param parts  files, in any order; of an animated asset, those of one frame
/// @throws InputError for a file that is no shard, shards of different bakes or of different
/// numbers, a shard that is missing or given twice; IoError, MemoryError, Cancelled
BakedFile mergeVdb(const std::vector<std::string>& parts, const std::string& path,
                   const Context& context = {});

}  // namespace octet
