// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "../base/types.h"

namespace octet {

/// @brief A linear functional of coefficients: sum over k of weight[k] times coefficient index[k].
/// Indices ascend and are distinct.
struct SparseRow {
  std::vector<Index> index;
  std::vector<double> weight;

  std::size_t size() const { return index.size(); }
  /// The functional applied to coefficients.
  double apply(const double* coefficients) const {
    double sum = 0;
    for (std::size_t k = 0; k < index.size(); ++k) sum += weight[k] * coefficients[index[k]];
    return sum;
  }
};

/// @brief Adds terms up to one SparseRow after the other. One per thread; size is that of the
/// coefficients, memory for a row goes with the row.
class RowSum {
 public:
  explicit RowSum(Index size) : values_(size, 0.0), present_(size, 0) {}

  void add(Index index, double weight) {
    if (!present_[index]) {
      present_[index] = 1;
      touched_.push_back(index);
    }
    values_[index] += weight;
  }

  /// The sum so far, and starts anew.
  SparseRow take() {
    std::sort(touched_.begin(), touched_.end());
    SparseRow row;
    row.index.reserve(touched_.size());
    row.weight.reserve(touched_.size());
    for (const Index k : touched_) {
      if (values_[k] != 0) {
        row.index.push_back(k);
        row.weight.push_back(values_[k]);
      }
      values_[k] = 0;
      present_[k] = 0;
    }
    touched_.clear();
    return row;
  }

 private:
  std::vector<double> values_;
  std::vector<std::uint8_t> present_;
  std::vector<Index> touched_;
};

}  // namespace octet
