// SPDX-License-Identifier: Apache-2.0
#include "failure.h"

#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include <octet/core/base/memory_budget.h>

#include "console.h"
#include "progress.h"

namespace octet::cli {
namespace {

/// Longest message; names in a malformed file can be of any length.
constexpr std::size_t kLongestMessage = 4000;

/// One line, whatever the names in the message hold.
std::string oneLine(std::string message) {
  for (char& c : message) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  }
  if (message.size() > kLongestMessage) message = message.substr(0, kLongestMessage) + "...";
  return message;
}

Failure named(int code, const char* kind, const Error& e) {
  return {code, kind, e.what(), e.file(), e.place(), e.reason(), 0, 0};
}

}  // namespace

Failure failureOf(const std::exception& e) {
  if (const auto* cancelled = dynamic_cast<const Cancelled*>(&e)) {
    return named(kSignal + interruptSignal(), "cancelled", *cancelled);
  }
  if (const auto* input = dynamic_cast<const InputError*>(&e)) {
    return named(kBadInput, "input", *input);
  }
  if (const auto* memory = dynamic_cast<const MemoryError*>(&e)) {
    Failure failure = named(kNoMemory, "memory", *memory);
    failure.neededBytes = memory->needed();
    failure.availableBytes = memory->available();
    return failure;
  }
  if (const auto* io = dynamic_cast<const IoError*>(&e)) return named(kFailed, "io", *io);
  if (const auto* other = dynamic_cast<const Error*>(&e)) return named(kFailed, "failed", *other);
  if (dynamic_cast<const std::bad_alloc*>(&e)) {
    return {kNoMemory, "memory", "not enough memory", "", "", "not enough memory", 0, 0};
  }
  return {kFailed, "failed", e.what(), "", "", e.what(), 0, 0};
}

nlohmann::ordered_json toJson(const Failure& failure) {
  nlohmann::ordered_json error = {
      {"code", failure.code}, {"kind", failure.kind}, {"message", oneLine(failure.message)}};
  const auto add = [&](const char* key, const std::string& part) {
    if (!part.empty()) error[key] = oneLine(part);
  };
  add("file", failure.file);
  add("place", failure.place);
  add("reason", failure.reason);
  if (failure.neededBytes > 0) {
    error["needed_bytes"] = failure.neededBytes;
    error["available_bytes"] = failure.availableBytes;
  }
  return error;
}

int tell(const Failure& failure, bool json) {
  clearProgress();
  const std::string message = oneLine(failure.message);
  if (progressStyle() == ProgressStyle::OpenJd) {
    std::cerr << "openjd_fail: " << message << "\n";
  }
  if (json) std::cout << text({{"error", toJson(failure)}}) << std::endl;
  std::cerr << "octetvdb: " << message << "\n";
  return failure.code;
}

}  // namespace octet::cli
