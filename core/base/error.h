// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace octet {

/// The one family of exceptions the library throws: what went wrong, where, and in which file.
/// `what()` reads "file: place: reason", leaving out the parts that are unknown.
class Error : public std::runtime_error {
 public:
  Error(std::string file, std::string place, std::string reason)
      : std::runtime_error(join(file, place, reason)),
        file_(std::move(file)),
        place_(std::move(place)),
        reason_(std::move(reason)) {}

  const std::string& file() const { return file_; }
  const std::string& place() const { return place_; }
  const std::string& reason() const { return reason_; }

 private:
  static std::string join(const std::string& file, const std::string& place,
                          const std::string& reason) {
    std::string text;
    for (const std::string* part : {&file, &place}) {
      if (!part->empty()) text += *part + ": ";
    }
    return text + reason;
  }

  std::string file_, place_, reason_;
};

/// The user's data or request cannot be used: malformed mesh, file or option value.
class InputError : public Error {
 public:
  explicit InputError(std::string place, std::string reason)
      : Error("", std::move(place), std::move(reason)) {}
  InputError(std::string file, std::string place, std::string reason)
      : Error(std::move(file), std::move(place), std::move(reason)) {}

  /// The same error, seen from the file it came from.
  InputError inFile(const std::string& file) const { return InputError(file, place(), reason()); }
};

/// The environment failed: a file cannot be written, memory or disk ran out.
class IoError : public Error {
 public:
  IoError(std::string file, std::string reason) : Error(std::move(file), "", std::move(reason)) {}
};

/// A progress callback asked to stop.
class Cancelled : public Error {
 public:
  Cancelled() : Error("", "", "cancelled") {}
};

}  // namespace octet
