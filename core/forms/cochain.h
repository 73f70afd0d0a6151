// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// @brief Coefficients of a discrete k-form: one per vertex (k = 0), edge (1, circulation), facet
/// (2, flux) or cell (3, mass) of a level, along each simplex's stored orientation. Cells count as
/// positively oriented. The type keeps edge data from being read as facet data.
template <int K>
class Cochain {
  static_assert(K >= 0 && K <= 3, "forms have degree 0 to 3");

 public:
  static constexpr int kDegree = K;

  Cochain() = default;
  explicit Cochain(const Complex& complex) : values_(complex.count(K), 0.0) {}
  explicit Cochain(Array<double> values) : values_(std::move(values)) {}

  Index size() const { return static_cast<Index>(values_.size()); }
  double& operator[](Index i) { return values_[i]; }
  double operator[](Index i) const { return values_[i]; }
  /// The coefficient along the reference's orientation.
  template <typename Ref>
  double at(Ref ref) const {
    return ref.sign() * values_[ref.index()];
  }
  const Array<double>& values() const { return values_; }
  Array<double>& values() { return values_; }
  double* data() { return values_.data(); }
  const double* data() const { return values_.data(); }

 private:
  Array<double> values_;
};

}  // namespace octet
