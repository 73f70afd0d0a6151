// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <octet/core/base/context.h>
#include <octet/core/geometry/box_bins.h>

namespace octet {

/// What the numbers of a velocity grid mean. Simulations store world units or voxels, per second
/// or per frame; the file does not say which.
struct VelocityReadOptions {
  std::string grid;       ///< name, of a vector grid or of a float triple; empty: found by name
  bool voxels = false;    ///< lengths are voxels along the grid's axes; else world units
  bool perFrame = false;  ///< times are frames; else seconds
  double framesPerSecond = 24;
  double scale = 1;  ///< factor besides
};

/// @brief A velocity field in a .vdb as any simulation writes it, sampled trilinearly at points in
/// world units: a vector grid (vec3s, vec3d; 16-bit files too), collocated or, when its class says
/// staggered, with component a half a voxel down axis a; or three float grids NAME.x/.y/.z,
/// NAME_x/_y/_z or NAMEX/Y/Z, each through its own transform. Any affine transform. Vectors are
/// along world axes unless the grid says that they are local (is_local_space) or they are given in
/// voxels: then they turn and stretch with the grid. Where nothing is stored the background counts.
///
/// Const members are thread safe. Cheap to copy.
class VelocitySource {
 public:
  /// @throws InputError when the file cannot be read, there is no such grid or several that could
  /// be meant, a value is not finite, or nothing is active. Cancelled
  VelocitySource(const std::string& path, const VelocityReadOptions& options,
                 const Context& context = {});

  /// World units per second.
  Vec3 at(const Vec3& point) const;

  const std::string& gridName() const;
  bool staggered() const;
  /// The shortest edge of a voxel, world units.
  double voxelSize() const;
  std::uint64_t activeVoxels() const;
  /// Box of the active voxels' samples.
  const Box& bounds() const;
  /// Where active voxels are, world units: all, or evenly thinned to at most `most`.
  /// @throws Cancelled
  std::vector<Vec3> voxelPositions(std::size_t most, const Context& context = {}) const;
  /// Divergence at a voxel, per second, by the grid's own differences: forward on a staggered grid,
  /// central on a collocated one.
  double divergenceAt(const Vec3& voxel) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace octet
