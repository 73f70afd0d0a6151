// SPDX-License-Identifier: Apache-2.0
#include "vdb_file.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include <openvdb/io/Compression.h>
#include <openvdb/openvdb.h>
#include <tbb/enumerable_thread_specific.h>

#include <octet/core/hodge/flux_rasterizer.h>
#include <octet/version.h>

#include "../io/atomic_file.h"
#include "measure_grid.h"
#include "vdb_input.h"

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

/// A file that reports how much was written; when that cancels, writing fails.
class ReportingFile : public std::filebuf {
 public:
  ReportingFile(std::string stage, const ProgressCallback& progress)
      : stage_(std::move(stage)), progress_(progress) {}
  bool cancelled() const { return cancelled_; }
  void finish() const { reportProgress(progress_, {stage_, written_, written_, "bytes"}); }

 protected:
  std::streamsize xsputn(const char* data, std::streamsize n) override {
    written_ += static_cast<std::size_t>(n);
    if (progress_ && written_ - reported_ >= kBytesPerReport) {
      reported_ = written_;
      cancelled_ |= !progress_({stage_, written_, 0, "bytes"});
    }
    return cancelled_ ? 0 : std::filebuf::xsputn(data, n);
  }

 private:
  static constexpr std::size_t kBytesPerReport = 1 << 20;

  std::string stage_;
  const ProgressCallback& progress_;
  std::size_t written_ = 0, reported_ = 0;
  bool cancelled_ = false;
};

/// OpenVDB gives each file a random tag; this one tells the content instead, so that the same bake
/// makes the same bytes. The tag follows 21 bytes: magic number, three versions and a flag.
void tagByContent(const std::string& path) {
  constexpr std::streamoff kTag = 21;
  constexpr std::size_t kLength = 36;
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  std::string tag(kLength, '\0');
  if (!file.seekg(kTag) || !file.read(tag.data(), kLength)) return;
  if (tag[8] != '-' || tag[13] != '-' || tag[18] != '-' || tag[23] != '-') return;  // no such tag
  // Two FNV-1a sums over eight bytes at a time.
  std::uint64_t sums[2] = {0xcbf29ce484222325ull, 0x84222325cbf29ce4ull};
  std::vector<std::uint64_t> block(1 << 17);
  while (file) {
    std::fill(block.begin(), block.end(), 0);
    file.read(reinterpret_cast<char*>(block.data()),
              static_cast<std::streamsize>(block.size() * sizeof block[0]));
    const std::size_t n = (static_cast<std::size_t>(file.gcount()) + 7) / 8;
    for (std::size_t k = 0; k < n; ++k) {
      sums[k & 1] = (sums[k & 1] ^ block[k]) * 0x100000001b3ull;
      sums[k & 1] ^= sums[k & 1] >> 29;
    }
  }
  file.clear();
  constexpr char kDigits[] = "0123456789abcdef";
  for (std::size_t k = 0, digit = 0; k < kLength; ++k) {
    if (tag[k] == '-') continue;
    tag[k] = kDigits[sums[digit / 16] >> (4 * (digit % 16)) & 15];
    ++digit;
  }
  file.seekp(kTag);
  file.write(tag.data(), kLength);
}

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
double magnitude(const openvdb::Vec3f& v) { return openvdb::Vec3d(v).length(); }

/// Keeps the larger absolute value; unlike std::max, also what is not a number.
void keepLargest(double* largest, float x) {
  const double size = std::abs(x);
  if (!std::isnan(*largest) && !(size <= *largest)) *largest = size;
}
void keepLargest(double* largest, const openvdb::Vec3f& v) {
  for (int k = 0; k < 3; ++k) keepLargest(largest, v[k]);
}

constexpr double kLargestHalf = 65504;

void checkRange(const VdbGridSpec& spec, double largest) {
  const double most = spec.half ? kLargestHalf : std::numeric_limits<float>::max();
  if (largest <= most) return;
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", largest);
  throw InputError(
      "grid \"" + spec.name + "\"",
      "has values up to " + std::string(text) + ", more than " +
          (spec.half ? "16-bit floats hold (65504); bake it without half" : "32-bit floats hold"));
}

/// Leaves made by one thread.
template <typename Leaf>
struct LeafBatch {
  std::vector<std::unique_ptr<Leaf>> leaves;
  std::uint64_t active = 0;
  double min = HUGE_VAL, max = -HUGE_VAL, largest = 0;
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

openvdb::math::Transform::Ptr linearTransform(double voxelSize) {
  try {
    return openvdb::math::Transform::createLinearTransform(voxelSize);
  } catch (const openvdb::ArithmeticError&) {
    throw InputError("voxel size", "is too small for OpenVDB; scale the asset up");
  }
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
      keepLargest(&batch.largest, out[n]);
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
    checkRange(spec, batch.largest);
    for (auto& leaf : batch.leaves) grid->tree().addLeaf(leaf.release());
  }
  grid->setName(spec.name);
  auto transform = linearTransform(spec.frame.voxelSize);
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
      size = openvdb::Vec3d(it.getValue()).length();
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

VdbGridInfo VdbFile::add(const GradientField& field, const VdbGridSpec& spec,
                         const ProgressCallback& progress) {
  const auto tiles = [&](const std::function<void(const Tile<3>&)>& sink) {
    rasterizeDifferences(field, spec.frame, spec.sampling, sink, "bake " + spec.name, progress);
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

void VdbFile::write(const std::string& path, const std::vector<VdbMetadata>& fileMetadata,
                    const ProgressCallback& progress) const {
  AtomicFile file(path);
  ReportingFile buffer("write " + std::filesystem::path(path).filename().string(), progress);
  const auto fail = [&] {
    return IoError(path, std::string("cannot be written: ") +
                             (errno ? std::strerror(errno) : "the disk may be full"));
  };
  errno = 0;
  if (!buffer.open(file.temporaryPath(), std::ios::out | std::ios::binary | std::ios::trunc)) {
    throw fail();
  }
  std::ostream stream(&buffer);
  try {
    openvdb::MetaMap metadata;
    metadata.insertMeta("creator", openvdb::StringMetadata(std::string("OctetVDB ") + kVersion));
    addMetadata(&metadata, fileMetadata);
    VdbArchive().writeTo(stream, grids_->list, metadata);
  } catch (const openvdb::Exception& e) {
    if (buffer.cancelled()) throw Cancelled();
    throw IoError(path, std::string("cannot be written: ") + e.what());
  }
  if (buffer.cancelled()) throw Cancelled();
  if (!buffer.close() || !stream) throw fail();
  tagByContent(file.temporaryPath());
  buffer.finish();
  file.commit();
}

std::vector<VdbGridInfo> readVdbInfo(const std::string& path,
                                     std::vector<VdbMetadata>* fileMetadata) {
  const VdbContents contents = readVdb(path);
  if (fileMetadata) *fileMetadata = readMetadata(*contents.metadata);
  std::vector<VdbGridInfo> result;
  for (const openvdb::GridBase::Ptr& grid : *contents.grids) {
    VdbGridInfo info = describe(*grid);
    measureRange<openvdb::FloatGrid>(*grid, &info) ||
        measureRange<openvdb::Vec3SGrid>(*grid, &info) ||
        measureRange<openvdb::DoubleGrid>(*grid, &info) ||
        measureRange<openvdb::Vec3DGrid>(*grid, &info) ||
        measureRange<openvdb::Int32Grid>(*grid, &info) ||
        measureRange<openvdb::Int64Grid>(*grid, &info);
    result.push_back(std::move(info));
  }
  return result;
}

}  // namespace octet
