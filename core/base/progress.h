// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "error.h"

namespace octet {

/// What long work reports while it runs: the stage's name and how much of it is done.
struct ProgressReport {
  std::string stage;      ///< "refine level 3", "bake velocity", ...
  std::size_t done = 0;   ///< units finished, 0 <= done <= total
  std::size_t total = 0;  ///< units in this stage; 0 when that is not known
  const char* unit = "";  ///< what is counted: "cells", "leaves", ...
};

/// Called between pieces of work, always from the thread that started it; return false to cancel.
using ProgressCallback = std::function<bool(const ProgressReport&)>;

/// Reports to `callback` when there is one.
/// @throws Cancelled when the callback returns false.
inline void reportProgress(const ProgressCallback& callback, const ProgressReport& report) {
  if (callback && !callback(report)) throw Cancelled();
}

}  // namespace octet
