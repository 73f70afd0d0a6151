// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "context.h"

namespace octet {

/// Reports to `context`. @throws Cancelled
inline void reportProgress(const Context& context, const ProgressReport& report) {
  context.report(report);
}

}  // namespace octet
