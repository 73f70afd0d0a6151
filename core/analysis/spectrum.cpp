// SPDX-License-Identifier: Apache-2.0
#include "spectrum.h"

#if defined(__GNUC__) && !defined(__clang__) && __GNUC__ >= 12
// GCC sees a freed block of Spectra's used again where it was moved from.
#pragma GCC diagnostic ignored "-Wuse-after-free"
#endif

#include <algorithm>

#include <Spectra/GenEigsSolver.h>

#include "../base/error.h"
#include "dense_algebra.h"

namespace octet {
namespace {

using Complexes = std::vector<std::complex<double>>;

/// Singular values below this, relative to the largest, belong to the null space.
constexpr double kNull = 1e-9;

/// Puts eigenvalues that are one up to rounding together, as their mean, which is accurate even
/// where they are defective.
std::vector<Eigenvalue> grouped(Complexes values) {
  std::vector<Eigenvalue> result;
  std::vector<std::uint8_t> used(values.size(), 0);
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (used[k]) continue;
    // Everything that a chain of near neighbours reaches.
    std::vector<std::size_t> members = {k};
    used[k] = 1;
    std::complex<double> sum = 0;
    for (std::size_t m = 0; m < members.size(); ++m) {
      sum += values[members[m]];
      for (std::size_t j = 0; j < values.size(); ++j) {
        if (used[j] || std::abs(values[j] - values[members[m]]) > kSameEigenvalue) continue;
        used[j] = 1;
        members.push_back(j);
      }
    }
    Eigenvalue value;
    value.multiplicity = static_cast<int>(members.size());
    value.value = sum / static_cast<double>(members.size());
    // Complex ones come in pairs; what is left of rounding is not one.
    if (std::abs(value.value.imag()) < kSameEigenvalue) value.value = value.value.real();
    result.push_back(value);
  }
  std::stable_sort(result.begin(), result.end(), [](const Eigenvalue& a, const Eigenvalue& b) {
    const double x = std::abs(a.value), y = std::abs(b.value);
    return x != y ? x > y : a.value.imag() > b.value.imag();
  });
  return result;
}

Complexes eigenvalues(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXcd values = eigenvaluesOf(matrix);
  return Complexes(values.data(), values.data() + values.size());
}

Complexes leadingEigenvalues(const Eigen::MatrixXd& matrix) {
  Spectra::DenseGenMatProd<double> product(matrix);
  Spectra::GenEigsSolver<Spectra::DenseGenMatProd<double>> solver(product, kLeading, 3 * kLeading);
  solver.init();
  constexpr int kMostRestarts = 2000;
  const Eigen::Index found = solver.compute(Spectra::SortRule::LargestMagn, kMostRestarts, 1e-12);
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw InputError("", "the leading eigenvalues do not converge");
  }
  const auto values = solver.eigenvalues();
  return Complexes(values.data(), values.data() + found);
}

void findSpaces(const Eigen::MatrixXd& matrix, Eigenvalue* value) {
  Eigen::MatrixXcd shifted = matrix.cast<std::complex<double>>();
  shifted.diagonal().array() -= value->value;
  // The computed value of a defective one is off a little: it has one vector all the same.
  value->forms = nullSpace(shifted, kNull);
  value->left = nullSpace(shifted.adjoint(), kNull).adjoint();
  const Eigen::MatrixXcd pairing = value->left * value->forms;
  if (value->forms.cols() != value->multiplicity || pairing.rows() != pairing.cols()) return;
  value->left = solveSquare(pairing, value->left);
}

}  // namespace

std::vector<Eigenvalue> spectrum(const Eigen::MatrixXd& matrix, bool spaces) {
  if (matrix.rows() > kDenseRows) return grouped(leadingEigenvalues(matrix));
  auto result = grouped(eigenvalues(matrix));
  if (spaces) {
    for (Eigenvalue& value : result) findSpaces(matrix, &value);
  }
  return result;
}

std::vector<Eigenvalue> quotientSpectrum(const Eigen::MatrixXd& matrix,
                                         const Eigen::MatrixXd& known) {
  const Eigen::MatrixXd rest = orthonormalExtension(known).rightCols(matrix.rows() - known.cols());
  return spectrum(rest.transpose() * matrix * rest, false);
}

double invarianceDefect(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& columns) {
  const Eigen::MatrixXd image = matrix * columns;
  const Eigen::MatrixXd best = leastSquares(columns, image);
  return (image - columns * best).norm() / image.norm();
}

std::vector<Eigenvalue> subspaceSpectrum(const Eigen::MatrixXd& matrix,
                                         const Eigen::MatrixXd& columns) {
  return grouped(eigenvalues(leastSquares(columns, matrix * columns)));
}

}  // namespace octet
