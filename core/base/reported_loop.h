// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>

#include "context.h"
#include "parallel.h"

namespace octet {

/// parallelRanges whose threads poll `context` before each range, of `grain` at the most; when it
/// says so, all stop. @throws Cancelled
template <typename Count, typename Body>
void parallelRanges(Count count, const Body& body, const Context& context,
                    std::size_t grain = 1024) {
  if (!context) return parallelRanges<Count>(count, body, grain);
  std::atomic<bool> failed{false};
  const auto watched = [&](Count begin, Count end) {
    const Count step = static_cast<Count>(grain);
    for (Count next; begin < end; begin = next) {
      if (failed.load(std::memory_order_relaxed)) return;
      next = begin + std::min<Count>(step, end - begin);
      try {
        context.poll();
        body(begin, next);
      } catch (...) {
        failed = true;
        throw;
      }
    }
  };
  parallelRanges<Count>(count, watched, grain);
}

/// parallelFor that polls as these do. @throws Cancelled
template <typename Count, typename Body>
void parallelFor(Count count, const Body& body, const Context& context, std::size_t grain = 1024) {
  parallelRanges<Count>(
      count,
      [&](Count begin, Count end) {
        for (Count i = begin; i != end; ++i) body(i);
      },
      context, grain);
}

/// parallelFor that also reports how far it is. @throws Cancelled
template <typename Count, typename Body>
void reportedFor(Count count, const Body& body, const Context& context, const std::string& stage,
                 const char* unit, std::size_t grain = 1024) {
  constexpr Count kSlices = 50, kSmallest = 1 << 16;  // a slice of a second at the most, about
  const Count step = context ? std::max<Count>(kSmallest, count / kSlices) : count;
  const auto report = [&](Count done) {
    context.report({stage, static_cast<std::size_t>(done), static_cast<std::size_t>(count), unit});
  };
  for (Count begin = 0; begin < count; begin += std::min(step, count - begin)) {
    report(begin);
    parallelFor<Count>(
        std::min(step, count - begin), [&](Count i) { body(begin + i); }, context, grain);
  }
  report(count);
}

}  // namespace octet
