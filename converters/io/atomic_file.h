// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace octet {

/// @brief A file that appears complete or not at all: it is written under a temporary name beside
/// the final one, and renamed by `commit`. Without a commit the temporary file is removed.
class AtomicFile {
 public:
  /// @throws IoError when the folder does not exist or cannot be written.
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write; keeps the final name's extension.
  const std::string& temporaryPath() const { return temporary_; }

  /// Flushes to disk and renames.
  /// @throws IoError when that fails; the final name is then untouched.
  void commit();

 private:
  std::string path_, temporary_;
  bool committed_ = false;
};

}  // namespace octet
