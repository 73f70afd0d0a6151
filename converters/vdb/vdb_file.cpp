// SPDX-License-Identifier: Apache-2.0
#include "vdb_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <openvdb/io/Compression.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <tbb/enumerable_thread_specific.h>

#include <octet/core/hodge/flux_rasterizer.h>
#include <octet/version.h>

#include "../io/atomic_file.h"
#include "measure_grid.h"

namespace octet {
namespace {

/// Writes grids to a stream of our own, so that a full disk is noticed.
class VdbArchive : public openvdb::io::Archive {
 public:
  void writeTo(std::ostream& os, const openvdb::GridCPtrVec& grids,
               const openvdb::MetaMap& metadata) const {
    write(os, grids, /*seekable=*/true, metadata);
  }
};

/// The value of a sample as a file stores it.
template <typename Value, int C>
Value gridValue(const Tile<C>& tile, int n, bool half) {
  Value value;
  if constexpr (C == 1) {
    value = static_cast<Value>(tile.values[0][n]);
  } else {
    value = Value(static_cast<float>(tile.values[0][n]), static_cast<float>(tile.values[1][n]),
                  static_cast<float>(tile.values[2][n]));
  }
  return half ? openvdb::io::truncateRealToHalf(value) : value;
}

double magnitude(float x) { return x; }
double magnitude(const openvdb::Vec3f& v) { return v.length(); }

/// Leaves made by one thread.
template <typename Leaf>
struct LeafBatch {
  std::vector<std::unique_ptr<Leaf>> leaves;
  std::uint64_t active = 0;
  double min = HUGE_VAL, max = -HUGE_VAL;
};

void addMetadata(openvdb::MetaMap* map, const std::vector<VdbMetadata>& metadata) {
  for (const VdbMetadata& m : metadata) {
    if (const auto* text = std::get_if<std::string>(&m.value)) {
      map->insertMeta(m.name, openvdb::StringMetadata(*text));
    } else if (const auto* number = std::get_if<double>(&m.value)) {
      map->insertMeta(m.name, openvdb::DoubleMetadata(*number));
    } else {
      map->insertMeta(m.name, openvdb::Int32Metadata(std::get<std::int32_t>(m.value)));
    }
  }
}

std::vector<VdbMetadata> readMetadata(const openvdb::MetaMap& map) {
  std::vector<VdbMetadata> result;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    result.push_back({it->first, it->second->str()});
  }
  return result;
}

VdbGridInfo describe(const openvdb::GridBase& grid) {
  VdbGridInfo info;
  info.name = grid.getName();
  info.type = grid.valueType();
  info.gridClass = openvdb::GridBase::gridClassToString(grid.getGridClass());
  if (grid.valueType().rfind("vec3", 0) == 0) {
    info.vectorType = openvdb::GridBase::vecTypeToString(grid.getVectorType());
  }
  info.voxelSize = grid.voxelSize()[0];
  info.activeVoxels = grid.activeVoxelCount();
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  for (int k = 0; k < 3; ++k) {
    info.indexMin[k] = box.min()[k];
    info.indexMax[k] = box.max()[k];
  }
  info.half = grid.saveFloatAsHalf();
  info.metadata = readMetadata(grid);
  return info;
}

/// @param rasterize  calls its argument with the tiles of the grid
template <typename Grid, int C, typename Rasterize>
typename Grid::Ptr fill(const Rasterize& rasterize, const VdbGridSpec& spec, VdbGridInfo* info) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  using Value = typename Grid::ValueType;
  tbb::enumerable_thread_specific<LeafBatch<Leaf>> batches;
  const auto sink = [&](const Tile<C>& tile) {
    LeafBatch<Leaf>& batch = batches.local();
    auto leaf = std::make_unique<Leaf>(
        openvdb::Coord(tile.origin[0], tile.origin[1], tile.origin[2]), Value(0.0f), false);
    Value* out = leaf->buffer().data();
    for (int n = 0; n < Tile<C>::kSize; ++n) {
      out[n] = gridValue<Value>(tile, n, spec.half);
      if (!tile.isActive(n)) continue;
      const double size = magnitude(out[n]);
      batch.min = std::min(batch.min, size);
      batch.max = std::max(batch.max, size);
      ++batch.active;
    }
    typename Leaf::NodeMaskType mask;
    for (int x = 0; x < 8; ++x) mask.template getWord<openvdb::Index64>(x) = tile.active[x];
    leaf->setValueMask(mask);
    batch.leaves.push_back(std::move(leaf));
  };
  rasterize(sink);

  auto grid = Grid::create(Value(0.0f));
  double min = HUGE_VAL, max = -HUGE_VAL;
  for (LeafBatch<Leaf>& batch : batches) {
    min = std::min(min, batch.min);
    max = std::max(max, batch.max);
    for (auto& leaf : batch.leaves) grid->tree().addLeaf(leaf.release());
  }
  grid->setName(spec.name);
  auto transform = openvdb::math::Transform::createLinearTransform(spec.frame.voxelSize);
  const Vec3 origin = spec.frame.origin + spec.shift;
  transform->postTranslate(openvdb::Vec3d(origin[0], origin[1], origin[2]));
  grid->setTransform(transform);
  switch (spec.gridClass) {
    case VdbGridSpec::Class::Staggered:
      grid->setGridClass(openvdb::GRID_STAGGERED);
      break;
    case VdbGridSpec::Class::Fog:
      grid->setGridClass(openvdb::GRID_FOG_VOLUME);
      break;
    case VdbGridSpec::Class::Unknown:
      grid->setGridClass(openvdb::GRID_UNKNOWN);
  }
  if (C == 3) {
    grid->setVectorType(spec.vectorType == VdbGridSpec::VectorType::Covariant
                            ? openvdb::VEC_COVARIANT
                            : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  }
  grid->setSaveFloatAsHalf(spec.half);
  grid->setCreator(std::string("OctetVDB ") + kVersion);
  addMetadata(grid.get(), spec.metadata);
  if constexpr (C == 3) {
    addMetadata(grid.get(),
                {{kSamplingMetadata,
                  std::string(spec.sampling == Sampling::Staggered ? "staggered" : "collocated")}});
    addMetadata(grid.get(), {{"octet_method", spec.method}});
    if (!spec.note.empty()) addMetadata(grid.get(), {{"octet_note", spec.note}});
    info->certificate = measureGrid(*grid);
    addMetadata(grid.get(), toMetadata(*info->certificate));
  }
  const auto certificate = info->certificate;
  *info = describe(*grid);
  info->certificate = certificate;
  if (C == 3) info->method = spec.method;
  info->note = spec.note;
  info->leaves = grid->tree().leafCount();
  info->min = info->activeVoxels ? min : 0;
  info->max = info->activeVoxels ? max : 0;
  return grid;
}

void initialize() {
  openvdb::initialize();  // does nothing the second time
}

/// Range of the active values.
template <typename Grid>
bool measureRange(const openvdb::GridBase& base, VdbGridInfo* info) {
  const auto* grid = dynamic_cast<const Grid*>(&base);
  if (!grid) return false;
  info->leaves = grid->tree().leafCount();
  double min = HUGE_VAL, max = -HUGE_VAL;
  for (auto it = grid->cbeginValueOn(); it; ++it) {
    double size;
    if constexpr (openvdb::VecTraits<typename Grid::ValueType>::IsVec) {
      size = it.getValue().length();
    } else {
      size = static_cast<double>(it.getValue());
    }
    min = std::min(min, size);
    max = std::max(max, size);
  }
  if (min <= max) {
    info->min = min;
    info->max = max;
  }
  return true;
}

}  // namespace

struct VdbFile::Grids {
  openvdb::GridCPtrVec list;
};

VdbFile::VdbFile() : grids_(std::make_unique<Grids>()) { initialize(); }
VdbFile::~VdbFile() = default;
VdbFile::VdbFile(VdbFile&&) noexcept = default;

VdbGridInfo VdbFile::add(const VectorField& field, const VdbGridSpec& spec,
                         const ProgressCallback& progress) {
  const auto tiles = [&](const std::function<void(const Tile<3>&)>& sink) {
    rasterize<3>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name, progress);
  };
  VdbGridInfo info;
  grids_->list.push_back(fill<openvdb::Vec3SGrid, 3>(tiles, spec, &info));
  return info;
}

VdbGridInfo VdbFile::add(const PotentialField& field, const VdbGridSpec& spec,
                         const ProgressCallback& progress) {
  const auto tiles = [&](const std::function<void(const Tile<3>&)>& sink) {
    rasterizeFluxes(field, spec.frame, spec.sampling, sink, "bake " + spec.name, progress);
  };
  VdbGridInfo info;
  grids_->list.push_back(fill<openvdb::Vec3SGrid, 3>(tiles, spec, &info));
  return info;
}

VdbGridInfo VdbFile::add(const ScalarField& field, const VdbGridSpec& spec,
                         const ProgressCallback& progress) {
  const auto tiles = [&](const std::function<void(const Tile<1>&)>& sink) {
    rasterize<1>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name, progress);
  };
  VdbGridInfo info;
  grids_->list.push_back(fill<openvdb::FloatGrid, 1>(tiles, spec, &info));
  return info;
}

void VdbFile::write(const std::string& path, const std::vector<VdbMetadata>& fileMetadata) const {
  AtomicFile file(path);
  const auto fail = [&] {
    return IoError(path, std::string("cannot be written: ") +
                             (errno ? std::strerror(errno) : "the disk may be full"));
  };
  errno = 0;
  std::ofstream stream(file.temporaryPath(), std::ios::binary | std::ios::trunc);
  if (!stream) throw fail();
  try {
    openvdb::MetaMap metadata;
    metadata.insertMeta("creator", openvdb::StringMetadata(std::string("OctetVDB ") + kVersion));
    addMetadata(&metadata, fileMetadata);
    VdbArchive().writeTo(stream, grids_->list, metadata);
  } catch (const openvdb::Exception& e) {
    throw IoError(path, std::string("cannot be written: ") + e.what());
  }
  stream.close();
  if (!stream) throw fail();
  file.commit();
}

std::vector<VdbGridInfo> readVdbInfo(const std::string& path,
                                     std::vector<VdbMetadata>* fileMetadata) {
  initialize();
  if (!std::ifstream(path)) {
    throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  std::vector<VdbGridInfo> result;
  try {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    if (fileMetadata) *fileMetadata = readMetadata(*file.getMetadata());
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    for (const openvdb::GridBase::Ptr& grid : *grids) {
      VdbGridInfo info = describe(*grid);
      measureRange<openvdb::FloatGrid>(*grid, &info) ||
          measureRange<openvdb::Vec3SGrid>(*grid, &info) ||
          measureRange<openvdb::DoubleGrid>(*grid, &info) ||
          measureRange<openvdb::Vec3DGrid>(*grid, &info) ||
          measureRange<openvdb::Int32Grid>(*grid, &info) ||
          measureRange<openvdb::Int64Grid>(*grid, &info);
      result.push_back(std::move(info));
    }
    file.close();
  } catch (const openvdb::Exception& e) {
    throw InputError(path, "", std::string("is not a readable .vdb: ") + e.what());
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "is not a readable .vdb: it claims more memory than there is");
  }
  return result;
}

}  // namespace octet
