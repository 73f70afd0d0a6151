// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

#include "../base/parallel.h"
#include "../base/types.h"

namespace octet {

/// @brief Rows of a map from coarse to fine coefficients that only some fine simplices have: what a
/// rule adds to the homotopy at walls, or at stars of one kind (SCHEME.md sections 6b and 8).
/// Compressed; memory goes with the rows.
class LocalRows {
 public:
  LocalRows() = default;
  /// @param fine   the simplices that have a row, ascending
  /// @param terms  `terms(k, add)` calls `add(coarse simplex, weight)` for the row of `fine[k]`; it
  ///               is called twice for each, from many threads
  template <typename Terms>
  LocalRows(const std::vector<Index>& fine, const Terms& terms);

  bool empty() const { return fine_.empty(); }
  /// The fine simplices that have a row, ascending.
  const Array<Index>& fine() const { return fine_; }
  /// Calls `add(coarse simplex, weight times the row's)` for the row of a fine simplex, if any.
  template <typename Add>
  void row(Index fine, double weight, const Add& add) const;
  /// Adds the rows applied to coarse coefficients to the fine simplices that have them.
  void addTo(const double* coarse, double* fine) const;

 private:
  struct Term {
    Index coarse;
    double weight;
  };
  Array<Index> fine_, begin_;
  Array<Term> terms_;
};

template <typename Terms>
LocalRows::LocalRows(const std::vector<Index>& fine, const Terms& terms)
    : fine_(fine.begin(), fine.end()) {
  const Index count = static_cast<Index>(fine.size());
  begin_.assign(fine.size() + 1, 0);
  parallelFor<Index>(count, [&](Index k) { terms(k, [&](Index, double) { ++begin_[k + 1]; }); });
  for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  terms_.resize(begin_.back());
  parallelFor<Index>(count, [&](Index k) {
    Index at = begin_[k];
    terms(k, [&](Index coarse, double weight) { terms_[at++] = {coarse, weight}; });
  });
}

template <typename Add>
void LocalRows::row(Index fine, double weight, const Add& add) const {
  const auto found = std::lower_bound(fine_.begin(), fine_.end(), fine);
  if (found == fine_.end() || *found != fine) return;
  const auto k = found - fine_.begin();
  for (Index t = begin_[k]; t < begin_[k + 1]; ++t)
    add(terms_[t].coarse, weight * terms_[t].weight);
}

inline void LocalRows::addTo(const double* coarse, double* fine) const {
  parallelFor<std::size_t>(fine_.size(), [&](std::size_t k) {
    double sum = 0;
    for (Index t = begin_[k]; t < begin_[k + 1]; ++t)
      sum += terms_[t].weight * coarse[terms_[t].coarse];
    fine[fine_[k]] += sum;
  });
}

}  // namespace octet
