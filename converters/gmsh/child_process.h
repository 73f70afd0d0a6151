// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>

namespace octet::gmsh_import {

struct ChildLimits {
  std::uint64_t memory = std::uint64_t{1} << 30;  ///< bytes beside those this process uses
  std::chrono::milliseconds time{60000};
  /// Asked several times a second while the child works; false ends it, as a failure.
  std::function<bool()> goOn;
};

/// What a child process returned, or how it failed ("crashed (signal 11)").
struct ChildResult {
  std::string bytes;
  std::string failure;
  bool stopped = false;  ///< by `goOn`
};

/// @brief Runs `work` in a copy of this process and returns its result: whatever it does - crash,
/// exit, print, hang, eat memory, change global state - this process stays as it is.
///
/// The copy has one thread only: `work` must not wait for other threads, so no oneTBB, no OpenMP.
/// Thread-safe. @throws IoError when no process can be started.
ChildResult runInChild(const std::function<std::string()>& work, const ChildLimits& limits);

}  // namespace octet::gmsh_import
