// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octet {

/// A mesh is subdivided at most this often: a single cell makes 10^11 by then.
inline constexpr int kMostLevels = 12;

}  // namespace octet
