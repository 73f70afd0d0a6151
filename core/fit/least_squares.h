// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "../base/context.h"
#include "../refine/sparse_row.h"

namespace octet {

/// @brief A regularised linear least-squares problem: the x of least
///     sum over rows of weight (row x - right)^2 + x' E x,   E symmetric, positive semidefinite.
struct LeastSquares {
  std::vector<SparseRow> rows;  ///< over the unknowns
  std::vector<double> weights, rights;
  const Eigen::SparseMatrix<double>* energy = nullptr;  ///< E
  Eigen::Index mostDirect = 7000;  ///< unknowns that are factorised; they take half a gigabyte
  Eigen::VectorXd energyPull;      ///< adds -2 energyPull' x to the cost; empty: 0
};

struct LeastSquaresSolution {
  Eigen::VectorXd x;
  bool direct = true;      ///< by Cholesky factorisation; else by conjugate gradients
  int iterations = 0;      ///< of conjugate gradients
  double residual = 0;     ///< of the normal equations, relative to their right side
  bool determined = true;  ///< false: rows and energy leave some direction open
};

/// @brief Solves it. Influences reach over many cells, so that normal equations fill almost
/// completely when factorised: up to `mostDirect` unknowns by dense Cholesky factorisation, beyond
/// by conjugate gradients with an incomplete factorisation, to a residual of 1e-9. Both with
/// iterative refinement on the original rows. Deterministic at any number of threads.
/// @throws Cancelled
LeastSquaresSolution solve(const LeastSquares& problem, const Context& context = {});

}  // namespace octet
