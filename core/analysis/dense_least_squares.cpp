// SPDX-License-Identifier: Apache-2.0
#include <Eigen/QR>

#include "dense_algebra.h"

namespace octet {

Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.householderQr().solve(b);
}

Eigen::MatrixXd orthonormalSpan(const Eigen::MatrixXd& columns) {
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), qr.rank());
}

Eigen::MatrixXd orthonormalExtension(const Eigen::MatrixXd& columns) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(columns);
  return qr.householderQ() * Eigen::MatrixXd::Identity(columns.rows(), columns.rows());
}

}  // namespace octet
