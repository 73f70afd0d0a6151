// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include "parallel.h"
#include "progress.h"

namespace octet {

/// parallelFor in slices with a report before each, so that a long loop can be watched and
/// cancelled. @throws Cancelled
template <typename Count, typename Body>
void reportedFor(Count count, const Body& body, const ProgressCallback& progress,
                 const std::string& stage, const char* unit, std::size_t grain = 1024) {
  constexpr Count kSlices = 50, kSmallest = 1 << 16;  // a slice of a second at the most, about
  const Count step = progress ? std::max<Count>(kSmallest, count / kSlices) : count;
  const auto report = [&](Count done) {
    reportProgress(progress,
                   {stage, static_cast<std::size_t>(done), static_cast<std::size_t>(count), unit});
  };
  for (Count begin = 0; begin < count; begin += std::min(step, count - begin)) {
    report(begin);
    parallelFor<Count>(
        std::min(step, count - begin), [&](Count i) { body(begin + i); }, grain);
  }
  report(count);
}

}  // namespace octet
