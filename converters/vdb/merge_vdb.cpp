// SPDX-License-Identifier: Apache-2.0
#include "merge_vdb.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <openvdb/io/File.h>

#include "measure_grid.h"
#include "vdb_input.h"
#include "vdb_output.h"
#include "wording.h"

namespace octet {
namespace {

struct PartFile {
  std::string path;
  GridPart part;
};

std::string placeOf(const openvdb::GridBase& grid) { return "grid \"" + grid.getName() + "\""; }

/// What the grids of a file are parts of. @throws InputError unless all are the same shard
GridPart shardOf(const std::string& path, const openvdb::GridPtrVec& grids) {
  std::optional<GridPart> shard;
  for (const openvdb::GridBase::Ptr& grid : grids) {
    std::optional<GridPart> part;
    try {
      part = partOf(*grid);
    } catch (const InputError& e) {
      throw InputError(path, placeOf(*grid), e.reason());
    }
    if (!part) throw InputError(path, placeOf(*grid), "is no part of a bake, but a whole grid");
    if (!part->shard) {
      throw InputError(path, placeOf(*grid), "is of a region; only shards can be merged");
    }
    if (shard && (shard->bake != part->bake || partName(*shard) != partName(*part))) {
      throw InputError(path, placeOf(*grid), "is of another part than the other grids of the file");
    }
    shard = part;
  }
  if (!shard) throw InputError(path, "", "has no grid");
  return *shard;
}

/// Looks at what files say that they are, and at none of their values.
PartFile look(const std::string& path) {
  openvdb::initialize();  // does nothing the second time
  if (!std::ifstream(path)) {
    throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  }
  try {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    return {path, shardOf(path, *file.readAllGridMetadata())};
  } catch (const openvdb::Exception& e) {
    throw InputError(path, "", std::string("is not a readable .vdb: ") + e.what());
  }
}

/// Refuses shards that are not all of one bake, each once.
void checkShards(const std::vector<PartFile>& files) {
  const PartFile& first = files.at(0);
  std::vector<const PartFile*> found(static_cast<std::size_t>(first.part.shard->count), nullptr);
  for (const PartFile& file : files) {
    const Shard& shard = *file.part.shard;
    if (file.part.bake != first.part.bake) {
      throw InputError(file.path, "",
                       "is of another bake than " + first.path +
                           ": another asset, frame, resolution, option or version");
    }
    if (shard.count != first.part.shard->count) {
      throw InputError(
          file.path, "",
          "is " + partName(file.part) + ", but " + first.path + " is " + partName(first.part));
    }
    if (shard.number < 1 || shard.number > shard.count) {
      throw InputError(file.path, "", "is " + partName(file.part) + ", which there is not");
    }
    const PartFile*& place = found[static_cast<std::size_t>(shard.number - 1)];
    if (place) {
      throw InputError(file.path, "", "is " + partName(file.part) + ", as is " + place->path);
    }
    place = &file;
  }
  std::string missing;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (!found[k]) missing += (missing.empty() ? "" : ", ") + std::to_string(k + 1);
  }
  if (!missing.empty()) {
    throw InputError("shards",
                     "of " + std::to_string(found.size()) + ", these are missing: " + missing);
  }
  std::vector<IndexBox> windows;
  for (const PartFile& file : files) windows.push_back(file.part.window);
  if (!coverAll(windows)) {
    throw InputError("shards", "were not cut alike: they overlap, or leave something out");
  }
}

/// Takes the leaves of a part into the whole.
template <typename Grid>
bool takeLeaves(const PartFile& file, const openvdb::GridBase::Ptr& from,
                const openvdb::GridBase::Ptr& to) {
  const auto part = openvdb::gridPtrCast<Grid>(from);
  const auto whole = openvdb::gridPtrCast<Grid>(to);
  if (!part || !whole) return false;
  if (part->tree().hasActiveTiles()) {
    throw InputError(file.path, placeOf(*from), "has tiles, which no bake makes");
  }
  std::vector<typename Grid::TreeType::LeafNodeType*> leaves;
  part->tree().stealNodes(leaves);
  bool outside = false;
  for (auto* leaf : leaves) {
    const openvdb::Coord& origin = leaf->origin();
    outside =
        outside || !file.part.window.contains({origin[0] >> 3, origin[1] >> 3, origin[2] >> 3});
    whole->tree().addLeaf(leaf);
  }
  if (outside) throw InputError(file.path, placeOf(*from), "has leaves outside of its part");
  return true;
}

double numberOf(const openvdb::GridBase& grid, const char* name) {
  const auto found = grid.getMetadata<openvdb::DoubleMetadata>(name);
  return found ? found->value() : 0;
}
std::string textOf(const openvdb::GridBase& grid, const char* name) {
  const auto found = grid.getMetadata<openvdb::StringMetadata>(name);
  return found ? found->value() : "";
}

/// Makes the metadata of a whole grid from those of its parts.
class GridMerger {
 public:
  /// @param part  the first; what it holds is moved into the whole
  GridMerger(const PartFile& file, const openvdb::GridBase::Ptr& part)
      : whole_(part->copyGridWithNewTree()) {
    std::vector<std::string> drop = {kPartialMetadata};
    for (auto it = part->beginMeta(); it != part->endMeta(); ++it) {
      // Also what OpenVDB says of a file.
      const bool ofPart =
          it->first.rfind(kPartMetadata, 0) == 0 || it->first.rfind("file_", 0) == 0;
      if (ofPart) drop.push_back(it->first);
    }
    for (const std::string& name : drop) whole_->removeMeta(name);
    // A map that moves nothing has been read as one that does not move.
    const auto transform = part->transform().copy();
    transform->postTranslate(openvdb::Vec3d(0.0));
    whole_->setTransform(transform);
    add(file, part);
  }

  void add(const PartFile& file, const openvdb::GridBase::Ptr& part) {
    if (part->getName() != whole_->getName() ||
        !(takeLeaves<openvdb::Vec3SGrid>(file, part, whole_) ||
          takeLeaves<openvdb::FloatGrid>(file, part, whole_))) {
      throw InputError(file.path, placeOf(*part), "is of another name or type than in the others");
    }
    sampled_ += numberOf(*part, kSampledMetadata);
    if (textOf(*part, kMethodMetadata) != methodName(GridMethod::Samples)) {
      method_ = textOf(*part, kMethodMetadata);
    }
  }

  VdbGridInfo finish(const Context& context) {
    const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(whole_);
    if (!vectors) return describe(*whole_, context);
    const std::string samples = methodName(GridMethod::Samples);
    addMetadata(whole_.get(), {{kMethodMetadata, method_.empty() ? samples : method_},
                               {kSampledMetadata, sampled_}});
    const Certificate certificate = measureGrid(*vectors, context);
    addMetadata(whole_.get(), toMetadata(certificate));
    VdbGridInfo info = describe(*whole_, context);
    info.certificate = certificate;
    info.sampledVoxels = static_cast<std::uint64_t>(sampled_);
    for (const GridMethod method :
         {GridMethod::Samples, GridMethod::Circulations, GridMethod::Differences}) {
      if (textOf(*whole_, kMethodMetadata) == methodName(method)) info.method = method;
    }
    return info;
  }

  openvdb::GridBase::ConstPtr grid() const { return whole_; }

 private:
  openvdb::GridBase::Ptr whole_;
  double sampled_ = 0;
  std::string method_;  // of a part that is not sampled
};

}  // namespace

BakedFile mergeVdb(const std::vector<std::string>& parts, const std::string& path,
                   const Context& context) {
  checkVdbName(path);
  if (parts.empty()) throw InputError("shards", "there are none");
  std::vector<PartFile> files;
  for (const std::string& part : parts) files.push_back(look(part));
  checkShards(files);
  std::vector<GridMerger> grids;
  openvdb::MetaMap::Ptr metadata;
  std::vector<MemoryReservation> memory;
  for (std::size_t k = 0; k < files.size(); ++k) {
    context.report({"read shards", k, files.size(), "files"});
    const VdbContents contents = readVdb(files[k].path, context);
    if (k > 0 && contents.grids->size() != grids.size()) {
      throw InputError(files[k].path, "", "has another number of grids than " + files[0].path);
    }
    double bytes = 0;
    for (const auto& grid : *contents.grids) bytes += static_cast<double>(grid->memUsage());
    memory.push_back(context.reserve(bytes, "the grids of " + files[k].path));
    if (k == 0) {
      metadata = contents.metadata;
      metadata->removeMeta(kPartMetadata);  // a whole has none
    }
    for (std::size_t n = 0; n < contents.grids->size(); ++n) {
      const openvdb::GridBase::Ptr& grid = (*contents.grids)[n];
      if (k == 0) {
        grids.emplace_back(files[k], grid);
      } else {
        grids[n].add(files[k], grid);
      }
    }
  }
  BakedFile merged{path, std::nullopt, {}};
  if (const auto frame = metadata->getMetadata<openvdb::Int32Metadata>(kFrameMetadata)) {
    merged.frame = frame->value();
  }
  openvdb::GridCPtrVec whole;
  for (GridMerger& grid : grids) {
    merged.grids.push_back(grid.finish(context));
    whole.push_back(grid.grid());
  }
  writeVdb(path, whole, *metadata, context);
  return merged;
}

}  // namespace octet
