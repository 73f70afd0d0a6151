// SPDX-License-Identifier: Apache-2.0
#include "vdb_input.h"

#include <cerrno>
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

}  // namespace octet
