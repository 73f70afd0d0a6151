// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>

#include "../base/context.h"

namespace octet {

/// @brief Finds the x of least energy x' M x / 2 - g' x with D x = b, M symmetric and positive
/// definite: the sparse saddle-point problem behind projections and potentials (SCHEME.md section
/// 9). With g = M t it is the x nearest to t. Rows of D may depend on one another, as those of a
/// coboundary do.
///
/// One factorisation of [M D'; D -delta], which is quasi-definite and so needs no pivoting, then a
/// few steps of iterative refinement remove delta. Const members are thread safe.
class ConstrainedMinimum {
 public:
  using Matrix = Eigen::SparseMatrix<double>;
  using Vector = Eigen::VectorXd;

  /// @throws InputError when M is not positive definite: cells with no volume. Cancelled
  ConstrainedMinimum(Matrix mass, Matrix constraint, const Context& context = {});

  /// What was found, and the largest |D x - b|: rounding when D x = b has a solution.
  struct Solution {
    Vector x;
    double residual = 0;
  };
  /// @param pull   g, one number per unknown
  /// @param right  b, one per row of D
  Solution solve(const Vector& pull, const Vector& right, const Context& context = {}) const;

 private:
  Matrix mass_, constraint_;
  double scale_ = 1;  // M is divided by it
  Eigen::SimplicialLDLT<Matrix> factors_;
};

}  // namespace octet
