// SPDX-License-Identifier: Apache-2.0
#include <Eigen/LU>
#include <Eigen/QR>

#include "dense_algebra.h"

namespace octet {

Eigen::VectorXcd leastSquares(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b) {
  return a.householderQr().solve(b);
}

Eigen::VectorXcd pivotedLeastSquares(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::MatrixXcd solveSquare(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
  return a.partialPivLu().solve(b);
}

}  // namespace octet
