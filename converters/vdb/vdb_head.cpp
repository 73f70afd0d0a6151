// SPDX-License-Identifier: Apache-2.0
#include "vdb_head.h"

#include <filesystem>
#include <fstream>

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>

namespace octet {
namespace {

/// What stands before the grids of a file, and where these end.
class Head : public openvdb::io::Archive {
 public:
  /// @return position of the end
  std::uint64_t read(std::istream& in, openvdb::MetaMap* metadata) {
    readHeader(in);
    metadata->readMeta(in);
    std::int64_t end = in.tellg();
    for (std::int32_t left = readGridCount(in); left > 0; --left) {
      openvdb::io::GridDescriptor grid;
      grid.read(in);
      grid.seekToEnd(in);
      end = grid.getEndPos();
    }
    return static_cast<std::uint64_t>(end);
  }
};

}  // namespace

std::optional<std::vector<VdbMetadata>> readVdbHead(const std::string& path) {
  openvdb::initialize();  // does nothing the second time
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) return std::nullopt;
  file.exceptions(std::ios::failbit | std::ios::badbit);
  openvdb::MetaMap map;
  try {
    openvdb::io::StreamMetadata::Ptr streamMetadata(new openvdb::io::StreamMetadata);
    openvdb::io::setStreamMetadataPtr(file, streamMetadata);
    if (Head().read(file, &map) > size) return std::nullopt;
  } catch (const openvdb::Exception&) {
    return std::nullopt;
  } catch (const std::exception&) {  // cut off in its head, or sizes that are none
    return std::nullopt;
  }
  std::vector<VdbMetadata> result;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    result.push_back({it->first, it->second->str()});
  }
  return result;
}

}  // namespace octet
