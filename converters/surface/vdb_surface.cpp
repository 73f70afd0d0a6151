// SPDX-License-Identifier: Apache-2.0
#include "vdb_surface.h"

#include <cmath>
#include <mutex>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

namespace octet {
namespace {

/// What meshToVolume needs to know of a mesh.
struct MeshAdapter {
  const TriangleSurface& surface;
  const openvdb::math::Transform& transform;

  std::size_t polygonCount() const { return surface.triangles.size(); }
  std::size_t pointCount() const { return surface.vertices.size(); }
  std::size_t vertexCount(std::size_t) const { return 3; }
  void getIndexSpacePoint(std::size_t n, std::size_t v, openvdb::Vec3d& p) const {
    const Vec3& x = surface.vertices[surface.triangles[n][v]];
    p = transform.worldToIndex(openvdb::Vec3d(x[0], x[1], x[2]));
  }
};

/// What OpenVDB's tools ask whether to stop, from any thread; then they return early.
class Stop {
 public:
  explicit Stop(const Context& context) : context_(context) {}

  void start(const char*) const {}
  void end() const {}
  bool wasInterrupted(int = -1) {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      if (!why_) context_.poll();
    } catch (...) {
      why_ = std::current_exception();
    }
    return why_ != nullptr;
  }
  /// Throws what ended the work, if anything did.
  void check() const {
    if (why_) std::rethrow_exception(why_);
  }

 private:
  const Context& context_;
  std::mutex mutex_;
  std::exception_ptr why_;
};

/// The largest active value, without which half of it is no isovalue.
template <typename Grid>
double largest(const Grid& grid) {
  double max = -HUGE_VAL;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    max = std::max(max, static_cast<double>(it.getValue()));
  }
  return max;
}

template <typename Grid>
TriangleSurface extract(const Grid& grid, const SurfaceReadOptions& options) {
  const bool levelSet = grid.getGridClass() == openvdb::GRID_LEVEL_SET;
  const double isovalue = options.isovalue ? *options.isovalue : levelSet ? 0 : largest(grid) / 2;
  if (!std::isfinite(isovalue))
    throw InputError("grid \"" + grid.getName() + "\"", "has no values");
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, quads, isovalue);
  if (quads.empty()) {
    throw InputError("grid \"" + grid.getName() + "\"",
                     "has no surface at the value " + std::to_string(isovalue));
  }
  TriangleSurface surface;
  for (const openvdb::Vec3s& p : points) {
    surface.vertices.emplace_back(p[0], p[1], p[2]);
    if (!surface.vertices.back().allFinite()) {
      throw InputError("grid \"" + grid.getName() + "\"", "holds values that are not finite");
    }
  }
  for (const openvdb::Vec4I& q : quads) {
    const auto at = [&](int k) { return static_cast<Index>(q[k]); };
    surface.triangles.push_back({at(0), at(1), at(2)});
    surface.triangles.push_back({at(0), at(2), at(3)});
  }
  return surface;
}

bool isScalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

}  // namespace

TriangleSurface readVdbSurface(const std::string& path, const SurfaceReadOptions& options) {
  openvdb::initialize();
  openvdb::GridBase::Ptr found;
  try {
    openvdb::io::File file(path);
    file.open();
    std::vector<std::string> names;
    const openvdb::GridPtrVecPtr grids = file.readAllGridMetadata();
    for (const auto& grid : *grids) {
      names.push_back(grid->getName());
      const bool wanted = options.grid.empty() ? isScalar(*grid) : grid->getName() == options.grid;
      if (!found && wanted) found = grid;
    }
    if (!found) {
      throw InputError(options.grid.empty() ? "" : "grid \"" + options.grid + "\"",
                       "there is none" + std::string(options.grid.empty() ? " of float" : "") +
                           "; the file has " + (names.empty() ? "no grid" : listOf(names)) +
                           didYouMean(options.grid, names));
    }
    if (!isScalar(*found)) {
      throw InputError("grid \"" + found->getName() + "\"", "is no float or double grid");
    }
    found = file.readGrid(found->getName());
  } catch (const openvdb::Exception& e) {
    throw InputError("", std::string("cannot be read: ") + e.what());
  }
  if (const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(found)) {
    return extract(*grid, options);
  }
  return extract(*openvdb::gridPtrCast<openvdb::DoubleGrid>(found), options);
}

SignedDistance sampledDistance(const TriangleSurface& surface, double voxelSize, double band,
                               const Context& context) {
  openvdb::initialize();
  const auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  // Index coordinates stay small however far from the origin the body is.
  const Vec3 centre = (surface.bounds().min + surface.bounds().max) / 2;
  transform->postTranslate(openvdb::Vec3d(centre[0], centre[1], centre[2]));
  const float width = static_cast<float>(std::ceil(band / voxelSize) + 1);
  Stop stop(context);
  const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      stop, MeshAdapter{surface, *transform}, *transform, width, width);
  stop.check();
  return [grid](const Vec3& p) -> double {
    const openvdb::Vec3d index =
        grid->constTransform().worldToIndex(openvdb::Vec3d(p[0], p[1], p[2]));
    return openvdb::tools::BoxSampler::sample(grid->tree(), index);
  };
}

}  // namespace octet
