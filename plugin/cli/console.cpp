// SPDX-License-Identifier: Apache-2.0
#include "console.h"

#include <chrono>
#include <csignal>
#include <cstdio>

#include <unistd.h>

namespace octet::cli {
namespace {

volatile std::sig_atomic_t interrupts = 0;

extern "C" void onInterrupt(int signal) {
  interrupts = 1;
  std::signal(signal, SIG_DFL);  // a second one ends the program at once
}

/// One line on the terminal, overwritten as work goes on.
class ProgressLine {
 public:
  bool report(const ProgressReport& report) {
    using namespace std::chrono;
    if (interrupts) {
      clear();
      return false;
    }
    const auto now = steady_clock::now();
    if (report.stage != stage_) {
      stage_ = report.stage;
      started_ = now;
    }
    const bool finished = report.done == report.total;
    if (!finished && now - shown_ < milliseconds(100) && report.done > 0) return true;
    shown_ = now;
    const double seconds = duration<double>(now - started_).count();
    const double rate = seconds > 0 ? static_cast<double>(report.done) / seconds : 0;
    std::fprintf(stderr, "\r\033[K%s", report.stage.c_str());
    if (report.total > 0 && report.done > 0) {
      std::fprintf(stderr, "  %3.0f %%",
                   100.0 * static_cast<double>(report.done) / static_cast<double>(report.total));
    }
    if (rate > 0) std::fprintf(stderr, "  %.3g %s/s", rate, report.unit);
    if (rate > 0 && !finished) {
      const double left = static_cast<double>(report.total - report.done) / rate;
      std::fprintf(stderr, "  %d:%02d left", static_cast<int>(left) / 60,
                   static_cast<int>(left) % 60);
    }
    std::fflush(stderr);
    if (finished) clear();
    return true;
  }

  ~ProgressLine() { clear(); }

 private:
  void clear() { std::fprintf(stderr, "\r\033[K"); }

  std::string stage_;
  std::chrono::steady_clock::time_point started_, shown_;
};

}  // namespace

void watchForInterrupt() { std::signal(SIGINT, onInterrupt); }
bool interrupted() { return interrupts != 0; }

ProgressCallback consoleProgress() {
  if (!::isatty(STDERR_FILENO)) {
    return [](const ProgressReport&) { return interrupts == 0; };
  }
  const auto line = std::make_shared<ProgressLine>();
  return [line](const ProgressReport& report) { return line->report(report); };
}

ControlAsset readAsset(const std::string& path) { return readControlAsset(path); }

std::string grouped(std::int64_t n) {
  std::string text = std::to_string(n);
  for (std::ptrdiff_t k = static_cast<std::ptrdiff_t>(text.size()) - 3; k > (n < 0 ? 1 : 0);
       k -= 3) {
    text.insert(static_cast<std::size_t>(k), ",");
  }
  return text;
}

}  // namespace octet::cli
