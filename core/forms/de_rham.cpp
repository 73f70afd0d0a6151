// SPDX-License-Identifier: Apache-2.0
#include "de_rham.h"

#include <Eigen/Dense>
#include <string>

#include "../base/error.h"

namespace octet {

/// Golub and Welsch: nodes are the eigenvalues of the Legendre polynomials' Jacobi matrix.
GaussRule::GaussRule(int n) {
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n), beside(std::max(n - 1, 0));
  for (int k = 1; k < n; ++k) beside[k - 1] = k / std::sqrt(4.0 * k * k - 1);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen;
  eigen.computeFromTridiagonal(diagonal, beside);
  for (int k = 0; k < n; ++k) {
    points.push_back((1 + eigen.eigenvalues()[k]) / 2);
    weights.push_back(std::pow(eigen.eigenvectors()(0, k), 2));
  }
}

DeRham::DeRham(const Complex& complex, const Array<Vec3>& positions, int order)
    : c_(complex), x_(positions), onEdge_(std::max(order, 0) / 2 + 1) {
  if (order < 0 || order > 40) {
    throw InputError("quadrature order", std::to_string(order) + " is not between 0 and 40");
  }
  // Collapsed products: their Jacobians add degrees 1 (triangle) and 2 (tetrahedron).
  const GaussRule rule((order + 2) / 2 + 1);
  const std::size_t n = rule.points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double r = rule.points[i];
    for (std::size_t j = 0; j < n; ++j) {
      const double s = rule.points[j];
      // (1 - r) from the first corner, split by s between the other two.
      onFacet_.push_back({1 - r, r * (1 - s), r * s, 2 * r * rule.weights[i] * rule.weights[j]});
      for (std::size_t k = 0; k < n; ++k) {
        const double t = rule.points[k];
        inTet_.push_back({r * (1 - s), r * s * (1 - t), r * s * t,
                          6 * r * r * s * rule.weights[i] * rule.weights[j] * rule.weights[k]});
      }
    }
  }
}

}  // namespace octet
