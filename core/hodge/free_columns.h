// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <vector>

namespace octet {

/// @brief The unknowns among some coefficients, when others are fixed.
class FreeColumns {
 public:
  /// @param fixed  1 where a coefficient is no unknown; empty: nowhere
  FreeColumns(Eigen::Index size, const std::vector<std::uint8_t>& fixed) : selection_(size, size) {
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index k = 0; k < size; ++k) {
      if (!fixed.empty() && fixed[static_cast<std::size_t>(k)]) continue;
      entries.emplace_back(k, static_cast<Eigen::Index>(list_.size()), 1.0);
      list_.push_back(k);
    }
    selection_.resize(size, count());
    selection_.setFromTriplets(entries.begin(), entries.end());
  }

  Eigen::Index count() const { return static_cast<Eigen::Index>(list_.size()); }
  /// A matrix' free columns.
  Eigen::SparseMatrix<double> columns(const Eigen::SparseMatrix<double>& m) const {
    return m * selection_;
  }
  /// A square matrix' free rows and columns.
  Eigen::SparseMatrix<double> block(const Eigen::SparseMatrix<double>& m) const {
    return selection_.transpose() * m * selection_;
  }
  /// A vector's free entries.
  Eigen::VectorXd rows(const Eigen::VectorXd& v) const { return selection_.transpose() * v; }
  /// Sets the fixed among all coefficients to 0.
  void clearOthers(double* all) const {
    Eigen::Map<Eigen::VectorXd> v(all, selection_.rows());
    v = (selection_ * rows(v)).eval();
  }
  /// Adds unknowns to all coefficients.
  void add(const Eigen::VectorXd& unknowns, double* all) const {
    for (Eigen::Index k = 0; k < count(); ++k)
      all[list_[static_cast<std::size_t>(k)]] += unknowns[k];
  }

 private:
  std::vector<Eigen::Index> list_;
  Eigen::SparseMatrix<double> selection_;
};

}  // namespace octet
