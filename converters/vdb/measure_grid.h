// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openvdb/openvdb.h>

#include "certificate.h"

namespace octet {

/// Measures a grid's stored values; active tiles are taken voxel by voxel. Instantiated for
/// Vec3SGrid and Vec3DGrid. Deterministic: the same numbers at any number of threads.
/// @throws Cancelled
template <typename Grid>
Certificate measureGrid(const Grid& grid, const Context& context = {});

/// Is a grid staggered? So its class says, or, where a target needs another, our own metadata.
bool isStaggered(const openvdb::GridBase& grid);

/// Our metadata that marks a staggered grid.
inline constexpr const char* kSamplingMetadata = "octet_sampling";

}  // namespace octet
