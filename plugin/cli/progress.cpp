// SPDX-License-Identifier: Apache-2.0
#include "progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include <unistd.h>

namespace octet::cli {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::duration;
using std::chrono::seconds;

ProgressStyle chosen = ProgressStyle::Auto;

/// One way to tell of it.
class Progress {
 public:
  virtual ~Progress() = default;
  virtual void report(const ProgressReport& report) = 0;
  virtual void clear() {}
  virtual void finish() {}
};

/// One line on the terminal, overwritten as work goes on: stage, rate and time left of it.
class Bar : public Progress {
 public:
  void report(const ProgressReport& report) override {
    const auto now = Clock::now();
    if (report.stage != stage_) {
      stage_ = report.stage;
      started_ = now;
    }
    const bool finished = report.done == report.total && report.total > 0;
    if (!finished && now - said_ < std::chrono::milliseconds(100) && report.done > 0) return;
    said_ = now;
    const double passed = duration<double>(now - started_).count();
    const double rate = passed > 0 ? static_cast<double>(report.done) / passed : 0;
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
    shown_ = true;
    if (finished) clear();
  }
  void clear() override {
    if (shown_) std::fprintf(stderr, "\r\033[K");
    shown_ = false;
  }

 private:
  std::string stage_;
  Clock::time_point started_, said_;
  bool shown_ = false;
};

/// Lines for logs: one for each tenth of the whole, and one each ten seconds.
class Plain : public Progress {
 public:
  /// @param quiet  how long nothing is said: who waits no longer needs no word
  explicit Plain(Clock::duration quiet) : quietUntil_(Clock::now() + quiet) {}

  void report(const ProgressReport& report) override {
    const auto now = Clock::now();
    const int tenths = static_cast<int>(10 * report.fraction + 1e-9);
    if (now < quietUntil_ || (tenths <= tenths_ && now - said_ < seconds(10))) return;
    tenths_ = std::max(tenths, tenths_);
    said_ = now;
    std::fprintf(stderr, "octetvdb: %3.0f %%  %s\n", std::floor(100 * report.fraction),
                 report.stage.c_str());
    std::fflush(stderr);
  }

 private:
  int tenths_ = 0;
  Clock::time_point quietUntil_, said_ = Clock::now();
};

/// A line each time that another whole percent is done or, where stages are told too, at a new one.
class Percents : public Progress {
 public:
  void report(const ProgressReport& report) override {
    const bool newStage = report.stage != stage_;
    const int percent = static_cast<int>(100 * report.fraction + 1e-9);
    if (!newStage && percent <= percent_) return;
    const bool more = percent > percent_;
    stage_ = report.stage;
    percent_ = std::max(percent, percent_);
    say(report, newStage, more);
    std::fflush(stderr);
  }
  void finish() override {
    if (percent_ >= 100) return;
    percent_ = 100;
    ProgressReport end;
    end.stage = stage_;
    end.fraction = 1;
    say(end, false, true);
  }

 protected:
  virtual void say(const ProgressReport& report, bool newStage, bool more) = 0;
  int percent() const { return percent_; }

 private:
  std::string stage_;
  int percent_ = -1;
};

class OpenJd : public Percents {
  void say(const ProgressReport& report, bool newStage, bool more) override {
    if (newStage) std::fprintf(stderr, "openjd_status: %s\n", report.stage.c_str());
    if (more) std::fprintf(stderr, "openjd_progress: %d\n", percent());
  }
};

class Alfred : public Percents {
  void say(const ProgressReport&, bool, bool more) override {
    if (more) std::fprintf(stderr, "ALF_PROGRESS %d%%\n", percent());
  }
};

class Json : public Percents {
  void say(const ProgressReport& report, bool, bool) override {
    using Document = nlohmann::ordered_json;
    const Document line = {{"stage", report.stage},
                           {"done", report.done},
                           {"total", report.total},
                           {"unit", report.unit},
                           {"fraction", report.fraction},
                           {"seconds", duration<double>(Clock::now() - started_).count()}};
    std::fprintf(stderr, "%s\n",
                 line.dump(-1, ' ', false, Document::error_handler_t::replace).c_str());
  }
  const Clock::time_point started_ = Clock::now();
};

std::unique_ptr<Progress> make(ProgressStyle style) {
  switch (style) {
    case ProgressStyle::Auto:
      if (::isatty(STDERR_FILENO)) return std::make_unique<Bar>();
      return std::make_unique<Plain>(seconds(1));
    case ProgressStyle::Bar:
      return std::make_unique<Bar>();
    case ProgressStyle::Plain:
      return std::make_unique<Plain>(seconds(0));
    case ProgressStyle::OpenJd:
      return std::make_unique<OpenJd>();
    case ProgressStyle::Alfred:
      return std::make_unique<Alfred>();
    case ProgressStyle::Json:
      return std::make_unique<Json>();
    case ProgressStyle::None:
      break;
  }
  return nullptr;
}

/// Made at the first call that is told of.
std::unique_ptr<Progress> current;

}  // namespace

const std::vector<std::pair<std::string, ProgressStyle>>& progressStyles() {
  static const std::vector<std::pair<std::string, ProgressStyle>> styles = {
      {"auto", ProgressStyle::Auto},     {"bar", ProgressStyle::Bar},
      {"plain", ProgressStyle::Plain},   {"openjd", ProgressStyle::OpenJd},
      {"alfred", ProgressStyle::Alfred}, {"json", ProgressStyle::Json},
      {"none", ProgressStyle::None}};
  return styles;
}

void setProgress(ProgressStyle style) { chosen = style; }
ProgressStyle progressStyle() { return chosen; }

ProgressCallback progressCallback() {
  if (!current) current = make(chosen);
  if (!current) return nullptr;
  return [](const ProgressReport& report) {
    if (!report.stage.empty()) current->report(report);
    return true;
  };
}

void clearProgress() {
  if (current) current->clear();
}

void finishProgress() {
  if (current) current->finish();
}

}  // namespace octet::cli
