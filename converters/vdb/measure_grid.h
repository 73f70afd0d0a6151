// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openvdb/openvdb.h>

#include "certificate.h"
#include "grid_part.h"

namespace octet {

/// Measures a grid's stored values. Of a part, what needs values beyond it is left out.
/// Instantiated for Vec3SGrid and Vec3DGrid. Deterministic: the same numbers at any number of
/// threads.
/// @throws Cancelled
template <typename Grid>
Certificate measureGrid(const Grid& grid, const Context& context = {});

/// What a grid is of a whole, as its metadata say; nothing of a whole.
/// @throws InputError when they make no sense
std::optional<GridPart> partOf(const openvdb::GridBase& grid);

/// Is a grid staggered? So its class says, or, where a target needs another, our own metadata.
bool isStaggered(const openvdb::GridBase& grid);

/// Our metadata that marks a staggered grid.
inline constexpr const char* kSamplingMetadata = "octet_sampling";

}  // namespace octet
