// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numeric>
#include <vector>

#include "types.h"

namespace octet {

/// @brief The numbers 0 to n - 1 in sets that are joined, each set found by one of its numbers.
/// Not thread safe: finding shortens paths.
class DisjointSets {
 public:
  explicit DisjointSets(Index n) : parent_(static_cast<std::size_t>(n)) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }
  /// The number that stands for k's set.
  Index find(Index k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  /// @return false when they were in one set already
  bool join(Index a, Index b) {
    a = find(a);
    b = find(b);
    parent_[a] = b;
    return a != b;
  }
  Index count() const {
    Index n = 0;
    for (std::size_t k = 0; k < parent_.size(); ++k) n += parent_[k] == static_cast<Index>(k);
    return n;
  }

 private:
  std::vector<Index> parent_;
};

}  // namespace octet
