// SPDX-License-Identifier: Apache-2.0
#include "run_program.h"

#include <algorithm>

#include <octet/core/base/system.h>

namespace octet {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskEvery{50};
/// What a program may take to end after it has closed its output.
constexpr milliseconds kGrace{2000};

class Run {
 public:
  Run(const std::vector<std::string>& command, std::string_view input, const RunLimits& limits)
      : limits_(limits), deadline_(Clock::now() + limits.time), rest_(input), child_(command) {
    if (rest_.empty()) child_.closeInput();
  }

  RunResult finish(const std::function<void(std::string_view)>& take) {
    std::string buffer(1 << 16, '\0');
    for (;;) {
      if (Clock::now() >= deadline_) return failed("did not finish within " + seconds());
      if (!goOn()) return {"was stopped", true};
      const auto moved = child_.exchange(rest_, buffer.data(), buffer.size(), patience());
      take(std::string_view(buffer.data(), moved.read));
      rest_.remove_prefix(moved.refused ? rest_.size() : moved.written);
      if (rest_.empty()) child_.closeInput();
      if (moved.closed) return failed(child_.wait(kGrace));
    }
  }

 private:
  static RunResult failed(std::string why) { return {std::move(why), false}; }

  std::string seconds() const { return std::to_string(limits_.time.count() / 1000) + " seconds"; }

  bool goOn() {
    if (!limits_.goOn || Clock::now() < nextQuestion_) return true;
    nextQuestion_ = Clock::now() + kAskEvery;
    return limits_.goOn();
  }

  milliseconds patience() const {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline_ - Clock::now());
    return std::max(milliseconds(1), limits_.goOn ? std::min(left, kAskEvery) : left);
  }

  const RunLimits& limits_;
  const Clock::time_point deadline_;
  Clock::time_point nextQuestion_;
  std::string_view rest_;
  system::ChildProcess child_;
};

}  // namespace

RunResult runProgram(const std::vector<std::string>& command, std::string_view input,
                     const std::function<void(std::string_view)>& take, const RunLimits& limits) {
  return Run(command, input, limits).finish(take);
}

}  // namespace octet
