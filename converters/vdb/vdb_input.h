// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <openvdb/openvdb.h>

#include "vdb_file.h"

/// @file
/// For the sources of this folder alone: it brings OpenVDB's headers.

namespace octet {

/// What a .vdb holds, all of it.
struct VdbContents {
  openvdb::GridPtrVecPtr grids;
  openvdb::MetaMap::Ptr metadata;
};

/// Reads a .vdb by any program. OpenVDB does not look whether its stream has ended, and then takes
/// sizes from what happens to be in memory; here a cut file is noticed where it ends.
/// @throws InputError when the file cannot be read, Cancelled
VdbContents readVdb(const std::string& path, const Context& context = {});

std::vector<VdbMetadata> readMetadata(const openvdb::MetaMap& map);

/// Describes a grid; without leaves and range, which cost a look at all values.
VdbGridInfo describeUnmeasured(const openvdb::GridBase& grid);
/// Describes a grid. @throws Cancelled
VdbGridInfo describe(const openvdb::GridBase& grid, const Context& context = {});

}  // namespace octet
