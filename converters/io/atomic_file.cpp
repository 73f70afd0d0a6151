// SPDX-License-Identifier: Apache-2.0
#include "atomic_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fcntl.h>
#include <unistd.h>

#include <octet/core/base/error.h>

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
  int file = -1;
  for (int attempt = 0; file < 0; ++attempt) {
    const std::string name = "." + target.stem().string() + "." + std::to_string(::getpid()) + "-" +
                             std::to_string(attempt) + ".tmp" + target.extension().string();
    temporary_ = (target.parent_path() / name).string();
    file = ::open(temporary_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (file < 0 && (errno != EEXIST || attempt == kMostAttempts)) {
      throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
    }
  }
  ::close(file);
}

AtomicFile::~AtomicFile() {
  if (!committed_) ::unlink(temporary_.c_str());
}

void AtomicFile::commit() {
  const int file = ::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC);
  const bool flushed = file >= 0 && ::fsync(file) == 0;
  const int error = errno;
  if (file >= 0) ::close(file);
  if (!flushed) throw IoError(path_, std::string("cannot be written: ") + std::strerror(error));
  if (::rename(temporary_.c_str(), path_.c_str()) != 0) {
    throw IoError(path_, std::string("cannot be written: ") + std::strerror(errno));
  }
  committed_ = true;
}

}  // namespace octet
