// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <octet/core/field/field.h>

namespace octet::testing {

/// How far the voxel values of a level are from those of the limit reconstruction three levels
/// deeper, over the voxels of a fixed grid that both have: root mean square, relative to that of
/// the values.
struct VoxelError {
  double all = 0;
  double inside = 0;  ///< only of voxels at least a sixth of the mesh' size from the boundary
};

/// Errors of levels 0, 1, ... for a smooth field sampled on the mesh as a 1-form or a 2-form. In
/// walls its boundary coefficients are set to 0 first: such forms are what the mode is for.
struct Convergence {
  int degree;
  BoundaryMode mode;
  std::vector<VoxelError> limit, whitney;
};

/// Of both degrees in both modes, levels 0 to levels - 1.
std::vector<Convergence> convergence(const ControlMesh& mesh, int levels);

struct ConvergenceMesh {
  const char* name;
  ControlMesh mesh;
};
/// A regular lattice; a ball as Gmsh meshes it; one of random points, with slivers; a creased box.
std::vector<ConvergenceMesh> convergenceMeshes();

/// Exponent of the mesh width in an error that fell from `coarse` to `fine` as the width halved.
double order(double coarse, double fine);

}  // namespace octet::testing
