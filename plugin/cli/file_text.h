// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include <octet/converters/vdb/bake.h>

namespace octet::cli {

/// Said behind the name of a file that was there already.
inline constexpr const char* kSkipped = "  is there, from the same asset and options";

/// A file that was made, with its grids, for --json.
nlohmann::ordered_json toJson(const BakedFile& file);

/// A file that was made as lines of text.
void print(const BakedFile& file);

}  // namespace octet::cli
