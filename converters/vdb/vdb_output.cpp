// SPDX-License-Identifier: Apache-2.0
#include "vdb_output.h"

#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <octet/core/base/error.h>

#include "../io/atomic_file.h"
#include "../io/content_hash.h"
#include "vdb_file.h"

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
  ContentHash hash;
  std::vector<std::uint64_t> block(1 << 17);
  while (file) {
    std::fill(block.begin(), block.end(), 0);
    file.read(reinterpret_cast<char*>(block.data()),
              static_cast<std::streamsize>(block.size() * sizeof block[0]));
    const std::size_t n = (static_cast<std::size_t>(file.gcount()) + 7) / 8;
    for (std::size_t k = 0; k < n; ++k) hash.add(block[k]);
  }
  file.clear();
  const std::string digits = hash.digits();
  for (std::size_t k = 0, digit = 0; k < kLength; ++k) {
    if (tag[k] != '-') tag[k] = digits[digit++];
  }
  file.seekp(kTag);
  file.write(tag.data(), kLength);
}

}  // namespace

void checkVdbName(const std::string& path) {
  const std::filesystem::path name(path);
  std::string extension = name.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  std::error_code ignored;
  if (extension == ".vdb" || std::filesystem::is_directory(name, ignored)) return;  // else: IoError
  throw InputError(path, "",
                   "does not end in .vdb, and an OpenVDB file is what is written; name it " +
                       name.stem().string() + ".vdb");
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

void writeVdb(const std::string& path, const openvdb::GridCPtrVec& grids,
              const openvdb::MetaMap& metadata, const Context& context) {
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
    VdbArchive().writeTo(stream, grids, metadata);
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

}  // namespace octet
