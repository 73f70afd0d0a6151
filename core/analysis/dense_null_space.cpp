// SPDX-License-Identifier: Apache-2.0
#include <Eigen/SVD>

#include "dense_algebra.h"

namespace octet {

Eigen::MatrixXcd nullSpace(const Eigen::MatrixXcd& matrix, double tolerance) {
  const Eigen::BDCSVD<Eigen::MatrixXcd> svd(matrix, Eigen::ComputeFullV);
  const auto& s = svd.singularValues();
  Eigen::Index dimension = 1;
  while (dimension < s.size() && s[s.size() - 1 - dimension] < tolerance * s[0]) ++dimension;
  return svd.matrixV().rightCols(dimension);
}

}  // namespace octet
