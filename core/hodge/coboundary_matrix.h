// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>

#include "../topology/complex.h"

namespace octet {

/// The exterior derivative of k-forms as a matrix (coboundary.h): one row per (k+1)-simplex, one
/// column per k-simplex of the level; 0 <= K <= 2.
template <int K>
Eigen::SparseMatrix<double> coboundaryMatrix(const Complex& complex);

}  // namespace octet
