// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace octet {

struct RunLimits {
  std::chrono::milliseconds time{60000};
  /// Is asked at the start and several times a second; false ends the program, as a failure.
  std::function<bool()> goOn;
};

/// How a run ended: well, or with the reason, as "crashed (signal 11)".
struct RunResult {
  std::string failure;
  bool stopped = false;  ///< by `goOn`
};

/// @brief Runs a program, feeds `input` to its standard input and hands its standard output to
/// `take` as it comes. Whatever the program does - crash, hang, print, close its input - this
/// process stays as it is, and the program is not left behind, nor when `goOn` or `take` throw.
///
/// Both are called by the thread that called this. A program that closes its input early has not
/// failed by that. Thread-safe.
/// @param command an executable file and its arguments
/// @throws IoError when the program cannot be started
RunResult runProgram(const std::vector<std::string>& command, std::string_view input,
                     const std::function<void(std::string_view)>& take, const RunLimits& limits);

}  // namespace octet
