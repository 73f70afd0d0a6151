// SPDX-License-Identifier: Apache-2.0
#include "velocity_source.h"

#include <algorithm>
#include <functional>
#include <map>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/enumerable_thread_specific.h>

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

#include "../vdb/vdb_input.h"

namespace octet {
namespace {

openvdb::Vec3d toVdb(const Vec3& p) { return {p[0], p[1], p[2]}; }
Vec3 fromVdb(const openvdb::Vec3d& p) { return {p[0], p[1], p[2]}; }

/// Names under which programs write velocity, in the order in which they are looked for.
const std::vector<std::string> kVelocityNames = {"velocity", "vel", "v", "Velocity", "Vel", "V"};
/// Endings of the three components' names.
const std::vector<std::array<std::string, 3>> kComponentEndings = {
    {".x", ".y", ".z"}, {"_x", "_y", "_z"}, {"X", "Y", "Z"}, {"x", "y", "z"}};

/// Trilinear samples of component `c` of a grid, in index space.
using Sampler = std::function<double(const openvdb::Vec3d& index, int c)>;

template <typename Grid>
Sampler makeSampler(const openvdb::GridBase::ConstPtr& base) {
  const auto grid = openvdb::gridConstPtrCast<Grid>(base);
  using Accessor = typename Grid::ConstAccessor;
  const auto accessors = std::make_shared<tbb::enumerable_thread_specific<Accessor>>(
      [grid] { return grid->getConstAccessor(); });
  return [accessors](const openvdb::Vec3d& index, int c) {
    const auto value = openvdb::tools::BoxSampler::sample(accessors->local(), index);
    if constexpr (openvdb::VecTraits<typename Grid::ValueType>::IsVec) {
      return static_cast<double>(value[c]);
    } else {
      (void)c;
      return static_cast<double>(value);
    }
  };
}

bool isVector(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>();
}
bool isScalar(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

Sampler samplerOf(const openvdb::GridBase::ConstPtr& grid) {
  if (grid->isType<openvdb::Vec3SGrid>()) return makeSampler<openvdb::Vec3SGrid>(grid);
  if (grid->isType<openvdb::Vec3DGrid>()) return makeSampler<openvdb::Vec3DGrid>(grid);
  if (grid->isType<openvdb::FloatGrid>()) return makeSampler<openvdb::FloatGrid>(grid);
  return makeSampler<openvdb::DoubleGrid>(grid);
}

/// Calls `visit(box, value)` for active voxels, and for tiles, boxes of one value.
template <typename Grid, typename Visit>
void visitActive(const openvdb::GridBase& base, const Context& context, const Visit& visit) {
  constexpr std::uint64_t kValuesPerPoll = 1 << 16;
  const auto& grid = static_cast<const Grid&>(base);
  std::uint64_t seen = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    if (++seen % kValuesPerPoll == 0) context.poll();
    openvdb::CoordBBox box;
    it.getBoundingBox(box);
    visit(box, it.getValue());
  }
}

template <typename Visit>
void visitActive(const openvdb::GridBase& grid, const Context& context, const Visit& visit) {
  if (grid.isType<openvdb::Vec3SGrid>()) visitActive<openvdb::Vec3SGrid>(grid, context, visit);
  if (grid.isType<openvdb::Vec3DGrid>()) visitActive<openvdb::Vec3DGrid>(grid, context, visit);
  if (grid.isType<openvdb::FloatGrid>()) visitActive<openvdb::FloatGrid>(grid, context, visit);
  if (grid.isType<openvdb::DoubleGrid>()) visitActive<openvdb::DoubleGrid>(grid, context, visit);
}

template <typename Value>
bool finite(const Value& value) {
  if constexpr (openvdb::VecTraits<Value>::IsVec) {
    return std::isfinite(value[0]) && std::isfinite(value[1]) && std::isfinite(value[2]);
  } else {
    return std::isfinite(value);
  }
}

/// The grids of a file by name.
class Reader {
 public:
  Reader(const std::string& path, const Context& context) : path_(path) {
    const VdbContents contents = readVdb(path, context);
    for (const openvdb::GridBase::Ptr& grid : *contents.grids) {
      names_.push_back(grid->getName());
      grids_.emplace(grid->getName(), grid);
    }
  }

  bool has(const std::string& name) const { return grids_.count(name) != 0; }
  const openvdb::GridBase::Ptr& grid(const std::string& name) const { return grids_.at(name); }

  /// The vector grid of that name, or the names of the triple that it stands for; empty: none.
  std::vector<std::string> resolve(const std::string& name) const {
    if (has(name) && isVector(*grid(name))) return {name};
    for (const auto& endings : kComponentEndings) {
      std::vector<std::string> triple;
      for (const std::string& ending : endings) {
        if (has(name + ending) && isScalar(*grid(name + ending))) {
          triple.push_back(name + ending);
        }
      }
      if (triple.size() == 3) return triple;
    }
    return {};
  }

  /// What is meant when no name is given: velocity by name, else the only vector grid.
  std::vector<std::string> find() const {
    for (const std::string& name : kVelocityNames) {
      const auto found = resolve(name);
      if (!found.empty()) return found;
    }
    std::vector<std::string> vectors;
    for (const std::string& name : names_) {
      if (isVector(*grid(name))) vectors.push_back(name);
    }
    if (vectors.size() > 1) {
      throw InputError(path_, "", "has several vector grids, choose one: " + listOf(vectors));
    }
    return vectors;
  }

  [[noreturn]] void fail(const std::string& name) const {
    throw InputError(path_, "",
                     (name.empty() ? std::string("has no velocity")
                                   : "has no vector grid or float triple \"" + name + "\"") +
                         "; its grids are " + (names_.empty() ? "none" : listOf(names_)) +
                         didYouMean(name, names_));
  }

 private:
  std::string path_;
  std::vector<std::string> names_;
  std::map<std::string, openvdb::GridBase::Ptr> grids_;
};

}  // namespace

struct VelocitySource::State {
  struct Component {
    openvdb::GridBase::Ptr grid;
    Sampler sample;
    int component;         // of the grid's value
    openvdb::Vec3d shift;  // added to index coordinates before sampling
  };

  std::string name;
  std::array<Component, 3> components;
  bool staggered = false;
  Eigen::Matrix3d axes;     // columns: a step of one voxel along each index axis, world units
  Eigen::Matrix3d toWorld;  // of stored vectors, with all factors
  double voxelSize = 0;
  std::uint64_t activeVoxels = 0;
  Box bounds;

  const openvdb::GridBase& first() const { return *components[0].grid; }

  Vec3 stored(const Vec3& point) const {
    Vec3 value;
    for (int c = 0; c < 3; ++c) {
      const Component& part = components[static_cast<std::size_t>(c)];
      value[c] = part.sample(part.grid->transform().worldToIndex(toVdb(point)) + part.shift,
                             part.component);
    }
    return value;
  }
};

VelocitySource::VelocitySource(const std::string& path, const VelocityReadOptions& options,
                               const Context& context) {
  auto state = std::make_shared<State>();
  {
    const Reader reader(path, context);
    const auto names = options.grid.empty() ? reader.find() : reader.resolve(options.grid);
    if (names.empty()) reader.fail(options.grid);
    for (int c = 0; c < 3; ++c) {
      const std::size_t k = names.size() == 3 ? static_cast<std::size_t>(c) : 0;
      auto& part = state->components[static_cast<std::size_t>(c)];
      part.grid = names.size() == 3 || c == 0 ? reader.grid(names[k]) : state->components[0].grid;
      part.sample = samplerOf(part.grid);
      part.component = c;
      if (!part.grid->transform().isLinear()) {
        throw InputError(path, "grid " + names[k], "has a transform that is not affine");
      }
      if (part.grid->getGridClass() == openvdb::GRID_STAGGERED) {
        state->staggered = true;
        part.shift[c] = 0.5;
      }
    }
    state->name = options.grid.empty() ? names[0] : options.grid;
  }

  for (const auto& part : state->components) {
    visitActive(*part.grid, context, [&](const openvdb::CoordBBox& box, const auto& value) {
      if (finite(value)) return;
      const openvdb::Coord& at = box.min();
      throw InputError(path, "grid " + part.grid->getName(),
                       "the value at voxel (" + std::to_string(at[0]) + ", " +
                           std::to_string(at[1]) + ", " + std::to_string(at[2]) +
                           ") is not finite");
    });
    if (part.grid == state->components[2].grid) break;  // one vector grid
  }

  const auto& transform = state->first().transform();
  const Vec3 origin = fromVdb(transform.indexToWorld(openvdb::Vec3d(0.0)));
  for (int k = 0; k < 3; ++k) {
    openvdb::Vec3d unit(0.0);
    unit[k] = 1;
    state->axes.col(k) = fromVdb(transform.indexToWorld(unit)) - origin;
    // A triple on the faces of voxels, as its own transforms say.
    const auto& part = state->components[static_cast<std::size_t>(k)];
    const openvdb::Vec3d apart = part.grid->transform().worldToIndex(toVdb(origin));
    if (k > 0 && std::abs(std::abs(apart[k]) - 0.5) < 1e-3) state->staggered = true;
  }
  state->voxelSize = state->axes.colwise().norm().minCoeff();
  const bool local = options.voxels || !state->first().isInWorldSpace();
  state->toWorld = local ? state->axes : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  state->toWorld *= options.scale * (options.perFrame ? options.framesPerSecond : 1);
  state->activeVoxels = state->first().activeVoxelCount();
  if (state->activeVoxels == 0) {
    throw InputError(path, "grid " + state->name, "has no active voxel");
  }
  const openvdb::CoordBBox box = state->first().evalActiveVoxelBoundingBox();
  for (int corner = 0; corner < 8; ++corner) {
    openvdb::Vec3d index;
    for (int k = 0; k < 3; ++k) index[k] = (corner >> k & 1) ? box.max()[k] : box.min()[k];
    state->bounds.extend(fromVdb(transform.indexToWorld(index)));
  }
  state_ = std::move(state);
}

Vec3 VelocitySource::at(const Vec3& point) const { return state_->toWorld * state_->stored(point); }
const std::string& VelocitySource::gridName() const { return state_->name; }
bool VelocitySource::staggered() const { return state_->staggered; }
double VelocitySource::voxelSize() const { return state_->voxelSize; }
std::uint64_t VelocitySource::activeVoxels() const { return state_->activeVoxels; }
const Box& VelocitySource::bounds() const { return state_->bounds; }

std::vector<Vec3> VelocitySource::voxelPositions(std::size_t most, const Context& context) const {
  const std::uint64_t stride = std::max<std::uint64_t>(1, (state_->activeVoxels + most - 1) / most);
  std::vector<Vec3> result;
  std::uint64_t next = 0;  // how many voxels are passed over before the next one
  visitActive(state_->first(), context, [&](const openvdb::CoordBBox& box, const auto&) {
    const openvdb::Coord size = box.dim();
    const std::uint64_t count = box.volume();
    for (; next < count; next += stride) {
      const auto at = [&](std::uint64_t n) { return static_cast<std::int32_t>(n); };
      const std::uint64_t column = next / size[2];
      const openvdb::Coord ijk =
          box.min().offsetBy(at(column / size[1]), at(column % size[1]), at(next % size[2]));
      result.push_back(fromVdb(state_->first().transform().indexToWorld(ijk)));
    }
    next -= count;
  });
  return result;
}

double VelocitySource::divergenceAt(const Vec3& voxel) const {
  // Derivatives along the index axes, then to world axes: div v = trace(dv/di . di/dx).
  const double step = state_->staggered ? 0.5 : 1.0;
  Eigen::Matrix3d derivatives;
  for (int k = 0; k < 3; ++k) {
    const Vec3 along = step * state_->axes.col(k);
    derivatives.col(k) = (at(voxel + along) - at(voxel - along)) / (2 * step);
  }
  return (derivatives * state_->axes.inverse()).trace();
}

}  // namespace octet
