// SPDX-License-Identifier: Apache-2.0
#include "console.h"

#include <cctype>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <octet/converters/gmsh/gmsh_import.h>
#include <octet/converters/io/atomic_file.h>
#include <octet/core/base/error.h>

namespace octet::cli {
namespace {

volatile std::sig_atomic_t interrupt = 0;
bool lineShown = false;  // is there a progress line on the terminal?

extern "C" void onInterrupt(int signal) {
  interrupt = signal;
  std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

/// One line on the terminal, overwritten as work goes on.
class ProgressLine {
 public:
  void report(const ProgressReport& report) {
    using namespace std::chrono;
    if (report.stage.empty()) return;
    const auto now = steady_clock::now();
    if (report.stage != stage_) {
      stage_ = report.stage;
      started_ = now;
    }
    const bool finished = report.done == report.total && report.total > 0;
    if (!finished && now - shown_ < milliseconds(100) && report.done > 0) return;
    shown_ = now;
    const double seconds = duration<double>(now - started_).count();
    const double rate = seconds > 0 ? static_cast<double>(report.done) / seconds : 0;
    std::fprintf(stderr, "\r\033[K%s", report.stage.c_str());
    if (report.total > 0 && report.done > 0) {
      std::fprintf(stderr, "  %3.0f %%",
                   100.0 * static_cast<double>(report.done) / static_cast<double>(report.total));
    }
    if (rate > 0) std::fprintf(stderr, "  %.3g %s/s", rate, report.unit);
    if (rate > 0 && report.total > report.done) {
      const double left = static_cast<double>(report.total - report.done) / rate;
      std::fprintf(stderr, "  %d:%02d left", static_cast<int>(left) / 60,
                   static_cast<int>(left) % 60);
    }
    std::fflush(stderr);
    lineShown = true;
    if (finished) clearProgress();
  }

 private:
  std::string stage_;
  std::chrono::steady_clock::time_point started_, shown_;
};

}  // namespace

void watchForInterrupt() {
  std::signal(SIGINT, onInterrupt);
  std::signal(SIGTERM, onInterrupt);
}
int interruptSignal() { return interrupt; }

void clearProgress() {
  if (lineShown) std::fprintf(stderr, "\r\033[K");
  lineShown = false;
}

Context consoleContext() {
  ContextParts parts;
  parts.stop = [] { return interrupt != 0; };
  parts.memoryLimit = memoryLimit();
  if (::isatty(STDERR_FILENO)) {
    const auto line = std::make_shared<ProgressLine>();
    parts.progress = [line](const ProgressReport& report) {
      line->report(report);
      return true;
    };
  }
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
