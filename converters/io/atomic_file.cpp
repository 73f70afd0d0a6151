// SPDX-License-Identifier: Apache-2.0
#include "atomic_file.h"

#include <filesystem>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

namespace octet {
namespace fs = std::filesystem;

/// Temporary files that killed programs may have left under the names that come first.
constexpr int kMostAttempts = 1000;

AtomicFile::AtomicFile(const std::string& path) : path_(path) {
  const fs::path target(path);
  std::error_code ignored;
  if (target.filename().empty() || fs::is_directory(target, ignored)) {
    throw IoError(path, "is a folder, not a file name");
  }
  // Renaming would put a file in the place of a device such as /dev/null.
  if (fs::exists(target, ignored) && !fs::is_regular_file(target, ignored)) {
    throw IoError(path, "is not a regular file");
  }
  // Creating it now tells at once whether the folder can be written. Other programs, in other
  // containers or on other machines with the same folder, may have the same number.
  std::error_code error;
  int attempt = 0;
  do {
    const std::string name = "." + target.stem().string() + "." +
                             std::to_string(system::processNumber()) + "-" +
                             std::to_string(attempt) + ".tmp" + target.extension().string();
    temporary_ = (target.parent_path() / name).string();
    error = system::createNewFile(temporary_);
  } while (error == std::errc::file_exists && attempt++ < kMostAttempts);
  if (error) throw IoError(path, "cannot be written: " + error.message());
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;
  if (!committed_) fs::remove(temporary_, ignored);
}

void AtomicFile::commit() {
  std::error_code error = system::flushToDisk(temporary_);
  if (!error) error = system::replaceFile(temporary_, path_);
  if (error) throw IoError(path_, "cannot be written: " + error.message());
  committed_ = true;
}

}  // namespace octet
