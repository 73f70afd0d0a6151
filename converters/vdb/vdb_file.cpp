// SPDX-License-Identifier: Apache-2.0
#include "vdb_file.h"

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <openvdb/openvdb.h>

#include <octet/core/raster/difference_rasterizer.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/raster/rasterizer.h>
#include <octet/version.h>

#include "../io/atomic_file.h"
#include "fill_grid.h"
#include "measure_grid.h"
#include "vdb_input.h"
#include "wording.h"

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

/// A file that reports how much was written.
class ReportingFile : public std::filebuf {
 public:
  ReportingFile(std::string stage, const Context& context)
      : stage_(std::move(stage)), context_(context) {}
  void finish() const { context_.report({stage_, written_, written_, "bytes"}); }

 protected:
  std::streamsize xsputn(const char* data, std::streamsize n) override {
    written_ += static_cast<std::size_t>(n);
    if (written_ - reported_ >= kBytesPerReport) {
      reported_ = written_;
      context_.report({stage_, written_, 0, "bytes"});
    }
    return std::filebuf::xsputn(data, n);
  }

 private:
  static constexpr std::size_t kBytesPerReport = 1 << 20;

  std::string stage_;
  const Context& context_;
  std::size_t written_ = 0, reported_ = 0;
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

void setClass(const VdbGridSpec& spec, openvdb::GridBase* grid) {
  switch (spec.gridClass) {
    case VdbGridSpec::Class::Staggered:
      return grid->setGridClass(openvdb::GRID_STAGGERED);
    case VdbGridSpec::Class::Fog:
      return grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    case VdbGridSpec::Class::Unknown:
      return grid->setGridClass(openvdb::GRID_UNKNOWN);
  }
}

void initialize() {
  openvdb::initialize();  // does nothing the second time
}

/// Range of the active values.
template <typename Grid>
bool measureRange(const openvdb::GridBase& base, const Context& context, VdbGridInfo* info) {
  const auto* grid = dynamic_cast<const Grid*>(&base);
  if (!grid) return false;
  info->leaves = grid->tree().leafCount();
  constexpr std::uint64_t kValuesPerPoll = 1 << 16;
  std::uint64_t seen = 0;
  double min = HUGE_VAL, max = -HUGE_VAL;
  for (auto it = grid->cbeginValueOn(); it; ++it) {
    if (++seen % kValuesPerPoll == 0) context.poll();
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

/// What a spec says about a grid, but for its values.
void label(const VdbGridSpec& spec, openvdb::GridBase* grid) {
  grid->setName(spec.name);
  auto transform = linearTransform(spec.frame.voxelSize);
  const Vec3 origin = spec.frame.origin + spec.shift;
  transform->postTranslate(openvdb::Vec3d(origin[0], origin[1], origin[2]));
  grid->setTransform(transform);
  setClass(spec, grid);
  grid->setSaveFloatAsHalf(spec.half);
  grid->setCreator(std::string("OctetVDB ") + kVersion);
  addMetadata(grid, spec.metadata);
}

/// Labels a vector grid, with how it was made and its certificate.
/// @param sampled  how many voxels hold samples, where others hold values of the method
VdbGridInfo finish(const VdbGridSpec& spec, GridMethod method, std::uint64_t sampled,
                   const Context& context, openvdb::Vec3SGrid* grid) {
  label(spec, grid);
  grid->setVectorType(spec.vectorType == VdbGridSpec::VectorType::Covariant
                          ? openvdb::VEC_COVARIANT
                          : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  const std::string sampling = spec.sampling == Sampling::Staggered ? "staggered" : "collocated";
  addMetadata(grid, {{kSamplingMetadata, sampling},
                     {"octet_method", std::string(methodName(method))},
                     {"octet_sampled_voxels", static_cast<double>(sampled)}});
  if (!spec.reasons.empty()) addMetadata(grid, {{"octet_note", words(spec.reasons)}});
  const Certificate certificate = measureGrid(*grid, context);
  addMetadata(grid, toMetadata(certificate));
  VdbGridInfo info = describe(*grid);
  measureRange<openvdb::Vec3SGrid>(*grid, context, &info);
  info.certificate = certificate;
  info.method = method;
  info.sampledVoxels = sampled;
  info.reasons = spec.reasons;
  return info;
}

}  // namespace

struct VdbFile::Grids {
  openvdb::GridCPtrVec list;
};

VdbFile::VdbFile() : grids_(std::make_unique<Grids>()) { initialize(); }
VdbFile::~VdbFile() = default;
VdbFile::VdbFile(VdbFile&&) noexcept = default;

VdbGridInfo VdbFile::add(const VectorField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterize<3>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name,
                     context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Samples, grid->activeVoxelCount(), context, grid.get());
}

VdbGridInfo VdbFile::add(const PotentialField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterizeFluxes(field, spec.frame, sink, "bake " + spec.name, context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Circulations, 0, context, grid.get());
}

VdbGridInfo VdbFile::add(const MeanFluxField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterize<3>(field.samples.source(), spec.frame, Sampling::Collocated, sink,
                     "sample " + spec.name, context.sub(0.3));
      },
      spec);
  const std::uint64_t replaced = replaceValues(
      [&](const auto& sink) {
        rasterizeMeanFluxes(field.potential, spec.frame, field.neighbours, sink,
                            "bake " + spec.name, context.sub(0.8));
      },
      spec, grid.get());
  grids_->list.push_back(grid);
  return finish(spec, replaced ? GridMethod::Circulations : GridMethod::Samples,
                grid->activeVoxelCount() - replaced, context, grid.get());
}

VdbGridInfo VdbFile::add(const GradientField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterizeDifferences(field, spec.frame, spec.sampling, sink, "bake " + spec.name,
                             context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Differences, 0, context, grid.get());
}

VdbGridInfo VdbFile::add(const ScalarField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::FloatGrid, 1>(
      [&](const auto& sink) {
        rasterize<1>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name,
                     context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  label(spec, grid.get());
  VdbGridInfo info = describe(*grid);
  measureRange<openvdb::FloatGrid>(*grid, context, &info);
  info.reasons = spec.reasons;
  return info;
}

void VdbFile::write(const std::string& path, const std::vector<VdbMetadata>& fileMetadata,
                    const Context& context) const {
  AtomicFile file(path);
  ReportingFile buffer("write " + std::filesystem::path(path).filename().string(), context);
  const auto fail = [&] {
    return IoError(path, std::string("cannot be written: ") +
                             (errno ? std::strerror(errno) : "the disk may be full"));
  };
  errno = 0;
  if (!buffer.open(file.temporaryPath(), std::ios::out | std::ios::binary | std::ios::trunc)) {
    throw fail();
  }
  std::ostream stream(&buffer);
  stream.exceptions(std::ios::badbit);  // else it would keep what a report throws
  try {
    openvdb::MetaMap metadata;
    metadata.insertMeta("creator", openvdb::StringMetadata(std::string("OctetVDB ") + kVersion));
    addMetadata(&metadata, fileMetadata);
    VdbArchive().writeTo(stream, grids_->list, metadata);
  } catch (const openvdb::Exception& e) {
    throw IoError(path, std::string("cannot be written: ") + e.what());
  } catch (const std::ios::failure&) {
    throw fail();
  }
  if (!buffer.close() || !stream) throw fail();
  tagByContent(file.temporaryPath());
  buffer.finish();
  file.commit();
}

std::vector<VdbGridInfo> readVdbInfo(const std::string& path,
                                     std::vector<VdbMetadata>* fileMetadata,
                                     const Context& context) {
  const VdbContents contents = readVdb(path, context);
  if (fileMetadata) *fileMetadata = readMetadata(*contents.metadata);
  std::vector<VdbGridInfo> result;
  for (const openvdb::GridBase::Ptr& grid : *contents.grids) {
    VdbGridInfo info = describe(*grid);
    measureRange<openvdb::FloatGrid>(*grid, context, &info) ||
        measureRange<openvdb::Vec3SGrid>(*grid, context, &info) ||
        measureRange<openvdb::DoubleGrid>(*grid, context, &info) ||
        measureRange<openvdb::Vec3DGrid>(*grid, context, &info) ||
        measureRange<openvdb::Int32Grid>(*grid, context, &info) ||
        measureRange<openvdb::Int64Grid>(*grid, context, &info);
    result.push_back(std::move(info));
  }
  return result;
}

}  // namespace octet
