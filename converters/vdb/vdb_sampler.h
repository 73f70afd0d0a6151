// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include <octet/core/geometry/box_bins.h>

namespace octet {

/// @brief A vector or scalar grid of a .vdb, by any writer, that can be sampled at points in world
/// units: through the grid's own transform, trilinearly between active voxels, components of a
/// staggered grid where they lie. The domain is every active voxel's cube around its sample; next
/// to inactive voxels, which hold no value, the active ones are weighted alone. Vectors are taken
/// as they are stored, in world units.
///
/// Const members are thread safe. Cheap to copy.
class VdbSampler {
 public:
  /// @param grid  name; empty: the first vector grid there is, else the first scalar one.
  /// @throws InputError when the file cannot be read, has no grid of that name, or the grid is of
  /// another type than vec3s, vec3d, float or double, has no active voxel or a value that is not
  /// finite.
  VdbSampler(const std::string& path, const std::string& grid);

  std::string name() const;
  int components() const;  ///< 1 or 3
  /// World box around the active voxels' cubes.
  const Box& bounds() const;
  /// Edge of a voxel, world units; the shortest where they differ.
  double voxelSize() const;
  std::string metadata(const std::string& name) const;  ///< of the grid as text; empty: none

  /// Value at a point, 1 or 3 numbers; false outside the domain, `value` is then untouched.
  bool sample(const Vec3& point, double* value) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace octet
