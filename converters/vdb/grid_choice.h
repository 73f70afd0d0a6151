// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake.h"

namespace octet {

/// How fine a bake is.
struct GridChoice {
  double voxelSize = 0;  ///< world units
  int levels = 0;        ///< subdivisions
};

/// The voxel size that is given, or follows from a resolution along the longest side of the
/// domain's limit surface; the levels that are given, or the fewest whose mean fine edge is at most
/// two voxels.
/// @throws InputError for sizes that are none, and for levels that need more memory than there is
GridChoice chooseGrid(const ControlMesh& mesh, const BakeOptions& options);

}  // namespace octet
