// SPDX-License-Identifier: Apache-2.0
#include "vdb_sampler.h"

#include <functional>

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

#include "vdb_input.h"

namespace octet {
namespace {

openvdb::Vec3d toVdb(const Vec3& p) { return {p[0], p[1], p[2]}; }
Vec3 fromVdb(const openvdb::Vec3d& p) { return {p[0], p[1], p[2]}; }

template <typename Value>
double component(const Value& value, int c) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) {
    return value[c];
  } else {
    return value;
  }
}

template <typename Value>
bool isFinite(const Value& value) {
  for (int c = 0; c < openvdb::VecTraits<Value>::Size; ++c) {
    if (!std::isfinite(component(value, c))) return false;
  }
  return true;
}

/// Trilinear between active voxels; only where the nearest is active.
/// @param c  component, -1: all
template <typename Grid>
bool interpolate(const Grid& grid, const openvdb::Vec3d& index, int c, double* value) {
  using Value = typename Grid::ValueType;
  constexpr int kSize = openvdb::VecTraits<Value>::Size;
  const typename Grid::ConstUnsafeAccessor accessor = grid.getConstUnsafeAccessor();
  if (!accessor.isValueOn(openvdb::Coord::round(index))) return false;
  const openvdb::Coord base = openvdb::Coord::floor(index);
  const openvdb::Vec3d part = index - base.asVec3d();
  double sum[3] = {0, 0, 0}, weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    openvdb::Coord at = base;
    for (int k = 0; k < 3; ++k) {
      const int up = corner >> k & 1;
      weight *= up ? part[k] : 1 - part[k];
      at[k] += up;
    }
    Value v;
    if (weight == 0 || !accessor.probeValue(at, v)) continue;
    weights += weight;
    for (int k = 0; k < kSize; ++k) sum[k] += weight * component(v, k);
  }
  for (int k = 0; k < kSize; ++k) {
    if (c < 0 || c == k) value[c < 0 ? k : 0] = sum[k] / weights;
  }
  return true;
}

/// World box around the cubes of voxels from `box.min()` to `box.max()`.
Box worldBox(const openvdb::GridBase& grid, const openvdb::CoordBBox& box) {
  Box result;
  for (int corner = 0; corner < 8; ++corner) {
    openvdb::Vec3d at;
    for (int k = 0; k < 3; ++k) {
      at[k] = corner >> k & 1 ? box.max()[k] + 0.5 : box.min()[k] - 0.5;
    }
    result.extend(fromVdb(grid.indexToWorld(at)));
  }
  return result;
}

bool isVector(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
}
bool isScalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

/// The grid of that name; without one the first vector grid, else the first scalar one.
openvdb::GridBase::Ptr chooseGrid(const openvdb::GridPtrVec& grids, const std::string& path,
                                  const std::string& name) {
  openvdb::GridBase::Ptr chosen;
  std::vector<std::string> names;
  for (const openvdb::GridBase::Ptr& grid : grids) {
    names.push_back(grid->getName());
    const bool usable = isVector(*grid) || isScalar(*grid);
    if (name.empty()) {
      if (usable && (!chosen || (isVector(*grid) && !isVector(*chosen)))) chosen = grid;
    } else if (grid->getName() == name && !chosen) {
      if (!usable) {
        throw InputError(path, "grid \"" + name + "\"",
                         "holds " + grid->valueType() + ", not float, double, vec3s or vec3d");
      }
      chosen = grid;
    }
  }
  if (chosen) return chosen;
  throw InputError(path, "",
                   name.empty()
                       ? "has no grid of type float, double, vec3s or vec3d"
                       : "has no grid \"" + name + "\"; it has " +
                             (names.empty() ? "none" : listOf(names)) + didYouMean(name, names));
}

}  // namespace

struct VdbSampler::State {
  openvdb::GridBase::ConstPtr grid;
  int components = 0;
  Box bounds;
  std::function<bool(const openvdb::Vec3d& index, int component, double* value)> sample;

  template <typename Grid>
  bool use(const std::string& path, const openvdb::GridBase::Ptr& base) {
    const auto typed = openvdb::gridConstPtrCast<Grid>(base);
    if (!typed) return false;
    const std::string place = "grid \"" + base->getName() + "\"";
    const openvdb::CoordBBox active = typed->evalActiveVoxelBoundingBox();
    if (active.empty()) throw InputError(path, place, "has no active voxel");
    for (auto it = typed->cbeginValueOn(); it; ++it) {
      if (isFinite(it.getValue())) continue;
      std::ostringstream where;
      where << it.getCoord();
      throw InputError(path, place, "the value of voxel " + where.str() + " is not finite");
    }
    grid = typed;
    components = openvdb::VecTraits<typename Grid::ValueType>::Size;
    bounds = worldBox(*base, active);
    sample = [typed](const openvdb::Vec3d& index, int c, double* value) {
      return interpolate(*typed, index, c, value);
    };
    return true;
  }
};

VdbSampler::VdbSampler(const std::string& path, const std::string& name) {
  const openvdb::GridBase::Ptr grid = chooseGrid(*readVdb(path).grids, path, name);
  const auto state = std::make_shared<State>();
  state->use<openvdb::Vec3SGrid>(path, grid) || state->use<openvdb::FloatGrid>(path, grid) ||
      state->use<openvdb::Vec3DGrid>(path, grid) || state->use<openvdb::DoubleGrid>(path, grid);
  if (!state->bounds.min.allFinite() || !state->bounds.max.allFinite()) {
    throw InputError(path, "grid \"" + grid->getName() + "\"",
                     "has a transform that is not finite");
  }
  state_ = state;
}

std::string VdbSampler::name() const { return state_->grid->getName(); }
int VdbSampler::components() const { return state_->components; }
const Box& VdbSampler::bounds() const { return state_->bounds; }
double VdbSampler::voxelSize() const {
  const openvdb::Vec3d size = state_->grid->voxelSize();
  return std::min({size[0], size[1], size[2]});
}

std::string VdbSampler::metadata(const std::string& name) const {
  const openvdb::Metadata::ConstPtr found = std::as_const(*state_->grid)[name];
  return found ? found->str() : "";
}

bool VdbSampler::sample(const Vec3& point, double* value) const {
  const openvdb::Vec3d index = state_->grid->worldToIndex(toVdb(point));
  if (components() == 1 || state_->grid->getGridClass() != openvdb::GRID_STAGGERED) {
    return state_->sample(index, -1, value);
  }
  // Component c of voxel ijk lies half a voxel lower along c.
  double result[3];
  for (int c = 0; c < 3; ++c) {
    openvdb::Vec3d at = index;
    at[c] += 0.5;
    if (!state_->sample(at, c, &result[c])) return false;
  }
  std::copy(result, result + 3, value);
  return true;
}

}  // namespace octet
