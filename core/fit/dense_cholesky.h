// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "../base/context.h"

namespace octet {

/// @brief Cholesky factorisation of a dense symmetric positive definite matrix on all threads,
/// block by block; the same bytes at any number of them.
class DenseCholesky {
 public:
  /// Takes the matrix' lower triangle.
  /// @throws Cancelled
  explicit DenseCholesky(Eigen::MatrixXd matrix, const Context& context = {});

  /// False when the matrix was not positive definite.
  bool succeeded() const { return succeeded_; }
  /// The smallest square of a pivot; for a matrix with diagonal 1, how far it is from singular.
  double smallestPivot() const;
  Eigen::VectorXd solve(const Eigen::VectorXd& right) const;

 private:
  Eigen::MatrixXd factor_;
  bool succeeded_ = true;
};

}  // namespace octet
