// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <openvdb/openvdb.h>

#include <octet/core/base/context.h>

#include "metadata.h"

/// @file
/// For the sources of this folder alone: it brings OpenVDB's headers.

namespace octet {

void addMetadata(openvdb::MetaMap* map, const std::vector<VdbMetadata>& metadata);

/// Writes grids to a file that appears complete or not at all. The same grids make the same bytes:
/// the file's unique tag is made from its content. @throws IoError, Cancelled
void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids,
              const openvdb::MetaMap& metadata, const Context& context);

}  // namespace octet
