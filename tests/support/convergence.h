// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <octet/core/field/field.h>

#include "meshes.h"

namespace octet::testing {

/// How far the voxel values of a level are from those of the limit reconstruction three levels
/// deeper, over the voxels of a fixed grid that both have: root mean square, relative to that of
/// the values.
struct VoxelError {
  double all = 0;
  double inside = 0;  ///< only of voxels at least a sixth of the mesh' size from the boundary
};

/// Errors of levels 0, 1, ...
struct Convergence {
  std::vector<VoxelError> limit, whitney;
};

/// A regular lattice, an irregular ball and a creased box, about 200 cells each.
std::vector<NamedMesh> convergenceMeshes();

/// Errors of levels 0 to levels - 1 for a smooth field sampled on the mesh as a K-form (K = 1, 2).
/// In walls its boundary coefficients are set to 0 first: such forms are what the mode is for.
template <int K>
Convergence convergence(const ControlMesh& mesh, BoundaryMode mode, int levels);

/// Exponent of the mesh width in an error that fell from `coarse` to `fine` as the width halved.
double order(double coarse, double fine);

}  // namespace octet::testing
