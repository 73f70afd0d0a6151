// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>

#include "../topology/complex.h"

namespace octet {

/// @brief What a fit pays for bending: a quadratic form on the control coefficients of a K-form v,
/// K = 1 or 2, from the complex's mass matrices (core/hodge/mass_matrix.h),
///
///     x' E x = (1/V) [ l^4 |Laplacian v|^2 + a l^2 |grad v|^2 + b |v|^2 ],
///
/// squared L2 norms over the domain of volume V, a = 0.1, b = 1e-6. The Laplacian is Hodge's,
/// d delta + delta d, with delta = M^-1 d' M; the inverse of a mass matrix is taken as diagonal,
/// with entries that make delta exact for constant and linear fields on symmetric stars. At the
/// boundary, where delta would need what is beyond, nothing is charged. The gradient is that of all
/// components, by differences between neighbouring cells: it needs nothing at the boundary, so that
/// constant fields are free but for the last term. In space the first term keeps point values
/// bounded (curves and points carry none for the second alone). It leaves harmonic fields open,
/// whose speed grows from the guides to the boundary: those the second charges, which |curl|^2 +
/// |div|^2 in its place would not where they are gradients. The third decides what is still open.
///
/// Units: those of v squared.
/// @param length  l in world units: details smaller than it are smoothed away
/// @param curl, divergence  which parts v can have; what is 0 by construction need not be charged
template <int K>
Eigen::SparseMatrix<double> smoothnessEnergy(const Complex& complex, const Array<Vec3>& positions,
                                             double length, bool curl, bool divergence);

/// Penalty |M0^-1/2 d0' M1 A|^2 on the divergence of a vector potential at the given vertices: with
/// it A is the one of least norm, and d A stays the same. @param vertices  1 where charged
Eigen::SparseMatrix<double> gaugeEnergy(const Complex& complex, const Array<Vec3>& positions,
                                        const std::vector<std::uint8_t>& vertices);

/// Volume of all cells.
double volumeOf(const Complex& complex, const Array<Vec3>& positions);

}  // namespace octet
