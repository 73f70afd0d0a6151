// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <exception>
#include <nlohmann/json_fwd.hpp>
#include <string>

/// @file
/// How the command ends when it does not end well.

namespace octet::cli {

/// Exit codes; a signal's is 128 and its number, as a shell reports it.
enum ExitCode {
  kDone = 0,
  kFailed = 1,     ///< the machine could not do it, or a limit of verify is passed
  kBadInput = 2,   ///< options, an asset or a file cannot be used; once more will not help
  kNoMemory = 33,  ///< needs more memory than there is: OpenCue retries it with more
  kSignal = 128
};

/// What went wrong.
struct Failure {
  int code = kFailed;
  const char* kind = "failed";  ///< usage, input, io, memory, cancelled or failed
  std::string message;          ///< all of it
  std::string file, place, reason;
  double neededBytes = 0, availableBytes = 0;  ///< of memory
};

/// What an exception of the library means.
Failure failureOf(const std::exception& e);

nlohmann::ordered_json toJson(const Failure& failure);

/// Tells of a failure: one line on stderr; with --json a document {"error": ...} on stdout, too,
/// for whoever reads that.
/// @return its exit code
int tell(const Failure& failure, bool json);

/// Ends the command with an exit code when its document, with the error in it, is already printed.
struct AlreadyTold {
  int code;
};

}  // namespace octet::cli
