// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>

#include "../base/error.h"
#include "dense_algebra.h"

namespace octet {
namespace {

Eigen::EigenSolver<Eigen::MatrixXd> solved(const Eigen::MatrixXd& matrix, bool vectors) {
  Eigen::EigenSolver<Eigen::MatrixXd> solver(matrix, vectors);
  if (solver.info() != Eigen::Success) throw InputError("", "the eigenvalues do not converge");
  return solver;
}

}  // namespace

EigenDecomposition eigenDecomposition(const Eigen::MatrixXd& matrix) {
  const auto solver = solved(matrix, true);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXcd eigenvaluesOf(const Eigen::MatrixXd& matrix) {
  return solved(matrix, false).eigenvalues();
}

}  // namespace octet
