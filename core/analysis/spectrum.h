// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace octet {

/// An eigenvalue of a subdivision matrix with its eigenspaces.
struct Eigenvalue {
  std::complex<double> value;
  int multiplicity = 0;  ///< as a root of the characteristic polynomial
  /// Eigenforms, one a column, of unit norm; fewer than the multiplicity where it is defective.
  Eigen::MatrixXcd forms;
  /// Left eigenvectors, one a row: what they read off a form, subdivision multiplies by `value`.
  /// Dual to `forms` where the eigenvalue is not defective.
  Eigen::MatrixXcd left;
};

/// Eigenvalues closer than this count as one: a defective one spreads by a root of rounding.
inline constexpr double kSameEigenvalue = 2e-5;
/// Matrices with more rows than this get their leading eigenvalues only, by Arnoldi iteration.
inline constexpr int kDenseRows = 1200;

/// @brief All eigenvalues of a matrix with their eigenspaces, largest magnitude first.
/// @param spaces  false: values and multiplicities only
/// Above kDenseRows rows: the leading kLeading ones, without spaces.
std::vector<Eigenvalue> spectrum(const Eigen::MatrixXd& matrix, bool spaces = true);
inline constexpr int kLeading = 60;

/// @brief The eigenvalues that are left when those of an invariant subspace (columns of `known`)
/// are taken out.
std::vector<Eigenvalue> quotientSpectrum(const Eigen::MatrixXd& matrix,
                                         const Eigen::MatrixXd& known);

/// How far columns are from spanning an invariant subspace: |M X - X B| / |M X|, B best.
double invarianceDefect(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& columns);

/// The spectrum of a matrix on an invariant subspace, given by columns.
std::vector<Eigenvalue> subspaceSpectrum(const Eigen::MatrixXd& matrix,
                                         const Eigen::MatrixXd& columns);

}  // namespace octet
