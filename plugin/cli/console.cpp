// SPDX-License-Identifier: Apache-2.0
#include "console.h"

#include <cctype>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include <octet/converters/gmsh/gmsh_import.h>
#include <octet/converters/io/atomic_file.h>
#include <octet/converters/io/frames.h>
#include <octet/core/base/error.h>

#include "progress.h"

namespace octet::cli {
namespace {

volatile std::sig_atomic_t interrupt = 0;

extern "C" void onInterrupt(int signal) {
  interrupt = signal;
  std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

}  // namespace

void watchForInterrupt() {
  std::signal(SIGINT, onInterrupt);
  std::signal(SIGTERM, onInterrupt);
}
int interruptSignal() { return interrupt; }

Context consoleContext() {
  ContextParts parts;
  parts.stop = [] { return interrupt != 0; };
  parts.memoryLimit = memoryLimit();
  parts.progress = progressCallback();
  return Context(std::move(parts));
}

ControlAsset readAsset(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension != ".msh" && extension != ".mesh" && extension != ".vtk") {
    return readControlAsset(path);
  }
  return readGmshMesh(path);
}

void checkOutput(const std::string& input, const std::string& output) {
  if (output.empty()) throw InputError("--output", "is empty");
  std::error_code absent;
  if (std::filesystem::equivalent(input, output, absent)) {
    throw InputError("--output", "is the input itself");
  }
  const AtomicFile trial(output);
}

void checkSingleOutput(const std::string& control, const std::string& output) {
  checkOutput(control, outputPath(output, std::nullopt));
}

std::string outputPath(const std::string& output, std::optional<int> frame) {
  try {
    return outputAt(output, frame);
  } catch (const InputError& e) {
    throw InputError("--output", e.reason());
  }
}

std::vector<int> readFrames(const std::string& text) {
  try {
    return parseFrames(text);
  } catch (const InputError& e) {
    throw InputError("--frames", e.reason());
  }
}

std::string text(const nlohmann::ordered_json& document) {
  return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string grouped(std::int64_t n) {
  std::string text = std::to_string(n);
  for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(text.size()) - 3; k > (n < 0 ? 1 : 0);
       k -= 3) {
    text.insert(static_cast<std::size_t>(k), ",");
  }
  return text;
}

std::string percent(std::uint64_t part, std::uint64_t whole) {
  const std::uint64_t thousandths = whole ? 1000 * part / whole : 0;
  return std::to_string(thousandths / 10) + "." + std::to_string(thousandths % 10) + " %";
}

}  // namespace octet::cli
