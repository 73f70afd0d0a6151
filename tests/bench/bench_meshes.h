// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/field/limit.h>
#include <octet/core/raster/rasterizer.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"

/// @file
/// What the benchmarks measure on: meshes of all kinds, each at three sizes.

namespace octet::bench {

/// Grids of benchmarks have this many samples in each direction.
inline constexpr int kResolution = 128;

/// A size is a number of levels: each level has eight times the cells of the one before.
struct Size {
  const char* name;  ///< about how many cells the finest level has
  int levels;
};
inline constexpr Size kSizes[] = {{"50k", 2}, {"500k", 3}, {"4M", 4}};

/// Names for `controlMesh`: regular inside and exact creases; regular but deformed, with smooth
/// boundaries; irregular everywhere.
inline constexpr const char* kMeshes[] = {"box", "lattice", "ball"};

/// @throws InputError for a name that is not in kMeshes.
ControlMesh controlMesh(const std::string& name);

/// @throws InputError for a name that is not in kSizes.
Size findSize(const std::string& name);

Refiner makeRefiner(const ControlMesh& mesh, int levels);

/// A grid of kResolution samples along the box's longest edge, the first one at its corner. Origin
/// and spacing have few digits, so that sample positions are exact however they are computed.
GridFrame frameOver(const Box& box);

}  // namespace octet::bench
