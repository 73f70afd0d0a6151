// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// @brief Tells which level of which control mesh simplices are numbered on. A level is numbered
/// alike however often its mesh is split: coefficients may go from one refiner to another.
struct Numbering {
  Numbering() = default;
  explicit Numbering(const Complex& complex);

  const Complex* control = nullptr;  ///< never read; null: unknown
  int level = 0;
};

/// Refuses coefficients that are not of a complex, by its numbering where theirs is known.
/// @param count  how many simplices the complex has
/// @throws InputError
void checkNumbering(int degree, Index size, const Numbering& own, Index count,
                    const Numbering& wanted);

/// @brief Coefficients of a discrete k-form: one per vertex (k = 0), edge (1, circulation), facet
/// (2, flux) or cell (3, mass) of a level, along each simplex's stored orientation. Cells count as
/// positively oriented. The type keeps edge data from being read as facet data, and what a cochain
/// knows of its complex keeps it from being read on another mesh or level of equal size.
template <int K>
class Cochain {
  static_assert(K >= 0 && K <= 3, "forms have degree 0 to 3");

 public:
  static constexpr int kDegree = K;

  Cochain() = default;
  /// Makes the form that is 0 everywhere.
  explicit Cochain(const Complex& complex) : values_(complex.count(K), 0.0), numbering_(complex) {}
  /// Takes coefficients on a complex. @throws InputError unless there are as many as simplices
  Cochain(const Complex& complex, Array<double> values)
      : values_(std::move(values)), numbering_(complex) {
    checkOn(complex);
  }
  /// Takes coefficients of which only the caller knows the complex.
  explicit Cochain(Array<double> values) : values_(std::move(values)) {}

  /// Refuses to be read on a complex that is not its own. @throws InputError
  void checkOn(const Complex& complex) const { checkOn(complex.count(K), Numbering(complex)); }
  void checkOn(Index count, const Numbering& numbering) const {
    checkNumbering(K, size(), numbering_, count, numbering);
  }

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
  Numbering numbering_;
};

}  // namespace octet
