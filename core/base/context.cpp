// SPDX-License-Identifier: Apache-2.0
#include "context.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

namespace octet {
namespace {
using Clock = std::chrono::steady_clock;
/// How long a callback is left alone at the most, while its thread polls.
constexpr std::chrono::milliseconds kPatience(50);
}  // namespace

/// What all copies and parts of one context share.
struct Context::Call {
  explicit Call(ContextParts given)
      : parts(std::move(given)), memory(std::make_shared<MemoryBudget>(parts.memoryLimit)) {}

  void poll() {
    if (stopped.load(std::memory_order_relaxed) || (parts.stop && parts.stop())) throw Cancelled();
    if (!parts.progress || speaking || std::this_thread::get_id() != thread) return;
    if (Clock::now() - spoken >= kPatience) speak();
  }
  void report(ProgressReport&& report, double fraction) {
    if (speaking) return;
    report.fraction = last.fraction = std::max(last.fraction, fraction);
    last = std::move(report);
    if (stopped.load(std::memory_order_relaxed) || (parts.stop && parts.stop())) throw Cancelled();
    if (parts.progress) speak();
  }

  const ContextParts parts;
  const std::shared_ptr<MemoryBudget> memory;
  std::atomic<bool> stopped{false};

 private:
  void speak() {
    struct Speaking {
      Call& call;
      ~Speaking() {
        call.speaking = false;
        call.spoken = Clock::now();
      }
    };
    speaking = true;
    const Speaking whileItLasts{*this};
    if (!parts.progress(last)) {
      stopped = true;
      throw Cancelled();
    }
  }

  // Of the thread that made the context alone.
  const std::thread::id thread = std::this_thread::get_id();
  ProgressReport last;
  Clock::time_point spoken = Clock::now();
  std::atomic<bool> speaking{false};  // a callback may start work whose tasks poll
};

/// A piece of 0 to 1.
struct Context::Part {
  double next = 0, end = 1;
  double size = 1;
};

Context::Context(ContextParts parts) {
  const bool limited = parts.memoryLimit < std::numeric_limits<double>::infinity();
  if (!parts.progress && !parts.stop && !limited) return;
  call_ = std::make_shared<Call>(std::move(parts));
  part_ = std::make_shared<Part>();
}

void Context::report(ProgressReport report) const {
  if (!call_) return;
  const double done =
      report.total > 0 ? static_cast<double>(report.done) / static_cast<double>(report.total) : 0;
  call_->report(std::move(report), part_->next + (part_->end - part_->next) * std::min(done, 1.0));
}

void Context::poll() const {
  if (call_) call_->poll();
}

void Context::stop() const {
  if (call_) call_->stopped = true;
}

Context Context::sub(double share) const {
  Context child = *this;
  if (!call_) return child;
  child.part_ = std::make_shared<Part>();
  child.part_->next = part_->next;
  part_->next = std::min(part_->end, part_->next + share * part_->size);
  child.part_->end = part_->next;
  child.part_->size = child.part_->end - child.part_->next;
  return child;
}

MemoryReservation Context::reserve(double bytes, const std::string& what) const {
  return call_ ? call_->memory->reserve(bytes, what) : MemoryReservation();
}

}  // namespace octet
