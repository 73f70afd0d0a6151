// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "metadata.h"

namespace octet {

/// Reads the metadata of a .vdb as a whole without its grids, and whether the grids' last byte is
/// there: for looks at many large files.
/// @return nothing when the file is not there, is no .vdb or is cut off
std::optional<std::vector<VdbMetadata>> readVdbHead(const std::string& path);

}  // namespace octet
