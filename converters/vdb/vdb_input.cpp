// SPDX-License-Identifier: Apache-2.0
#include "vdb_input.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include <openvdb/io/Stream.h>

#include <octet/core/base/error.h>

namespace octet {
namespace {

/// A file that asks whether to stop while it is read.
class PolledFile : public std::filebuf {
 public:
  explicit PolledFile(const Context& context) : context_(context) {}

 protected:
  std::streamsize xsgetn(char* data, std::streamsize n) override {
    constexpr std::streamsize kBytesPerPoll = 1 << 16;
    unpolled_ += n;
    if (unpolled_ >= kBytesPerPoll) {
      unpolled_ = 0;
      context_.poll();
    }
    return std::filebuf::xsgetn(data, n);
  }

 private:
  const Context& context_;
  std::streamsize unpolled_ = 0;
};

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

}  // namespace

VdbContents readVdb(const std::string& path, const Context& context) {
  openvdb::initialize();  // does nothing the second time
  errno = 0;
  PolledFile buffer(context);
  if (!buffer.open(path, std::ios::in | std::ios::binary)) {
    throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  std::istream file(&buffer);
  file.exceptions(std::ios::failbit | std::ios::badbit);  // badbit: also to keep what a poll throws
  try {
    openvdb::io::Stream stream(file, /*delayLoad=*/false);
    return {stream.getGrids(), stream.getMetadata()};
  } catch (const openvdb::Exception& e) {
    throw InputError(path, "", std::string("is not a readable .vdb: ") + e.what());
  } catch (const std::ios_base::failure&) {
    throw InputError(path, "", "is not a readable .vdb: it is cut off or damaged");
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "is not a readable .vdb: it claims more memory than there is");
  }
}

std::vector<VdbMetadata> readMetadata(const openvdb::MetaMap& map) {
  std::vector<VdbMetadata> result;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    result.push_back({it->first, it->second->str()});
  }
  return result;
}

VdbGridInfo describeUnmeasured(const openvdb::GridBase& grid) {
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
  for (int k = 0; k < 3 && !box.empty(); ++k) {
    info.indexMin[k] = box.min()[k];
    info.indexMax[k] = box.max()[k];
  }
  info.half = grid.saveFloatAsHalf();
  info.metadata = readMetadata(grid);
  return info;
}

VdbGridInfo describe(const openvdb::GridBase& grid, const Context& context) {
  VdbGridInfo info = describeUnmeasured(grid);
  measureRange<openvdb::FloatGrid>(grid, context, &info) ||
      measureRange<openvdb::Vec3SGrid>(grid, context, &info) ||
      measureRange<openvdb::DoubleGrid>(grid, context, &info) ||
      measureRange<openvdb::Vec3DGrid>(grid, context, &info) ||
      measureRange<openvdb::Int32Grid>(grid, context, &info) ||
      measureRange<openvdb::Int64Grid>(grid, context, &info);
  return info;
}

std::vector<VdbGridInfo> readVdbInfo(const std::string& path,
                                     std::vector<VdbMetadata>* fileMetadata,
                                     const Context& context) {
  const VdbContents contents = readVdb(path, context);
  if (fileMetadata) *fileMetadata = readMetadata(*contents.metadata);
  std::vector<VdbGridInfo> result;
  for (const openvdb::GridBase::Ptr& grid : *contents.grids) {
    result.push_back(describe(*grid, context));
  }
  return result;
}

}  // namespace octet
