// SPDX-License-Identifier: Apache-2.0
#include "vdb_input.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include <openvdb/io/Stream.h>

#include <octet/core/base/error.h>

namespace octet {

VdbContents readVdb(const std::string& path) {
  openvdb::initialize();  // does nothing the second time
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  file.exceptions(std::ios::failbit | std::ios::badbit);
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

}  // namespace octet
