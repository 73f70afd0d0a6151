// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

/// @file
/// Decompositions of dense matrices of any size. Eigen's templates for them are compiled in the
/// files dense_*.cpp and nowhere else: each costs many seconds and hundreds of megabytes.

namespace octet {

/// Eigenvalues of a real matrix and its eigenvectors, one a column.
struct EigenDecomposition {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;
};

/// @throws InputError when the iteration does not converge.
EigenDecomposition eigenDecomposition(const Eigen::MatrixXd& matrix);
/// As eigenDecomposition, without vectors.
Eigen::VectorXcd eigenvaluesOf(const Eigen::MatrixXd& matrix);

/// The x of least |a x - b|, for an `a` of full rank.
Eigen::MatrixXd leastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::VectorXcd leastSquares(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b);
/// An x of least |a x - b|, for an `a` of any rank.
Eigen::VectorXcd pivotedLeastSquares(const Eigen::MatrixXcd& a, const Eigen::VectorXcd& b);
/// The x with a x = b, for a square `a` that can be inverted.
Eigen::MatrixXcd solveSquare(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// Orthonormal basis of the span of columns, of any rank.
Eigen::MatrixXd orthonormalSpan(const Eigen::MatrixXd& columns);
/// Orthonormal basis of the whole space: the span of columns of full rank first, then its
/// complement.
Eigen::MatrixXd orthonormalExtension(const Eigen::MatrixXd& columns);

/// Orthonormal basis of what a square matrix sends to 0, up to `tolerance` relative to its norm; at
/// least one vector.
Eigen::MatrixXcd nullSpace(const Eigen::MatrixXcd& matrix, double tolerance);

}  // namespace octet
