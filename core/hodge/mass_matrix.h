// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>

#include "../topology/complex.h"

namespace octet {

/// @brief The mass matrix of the Whitney k-forms of a level: x' M y is the integral of the inner
/// product of the fields of the cochains x and y (SCHEME.md section 9), so x' M x is a field's
/// energy. Rows and columns are the level's simplices along their stored orientation; symmetric,
/// positive definite.
///
/// In a tetrahedron the integral is exact. An octahedron's form is the limit of its linear
/// refinement (thesis 3.2.3): on an octahedron that is an affine image of the regular one the
/// integral is exact again, as the fixed point of that refinement. On any other one the part of a
/// form that is a constant field is integrated exactly, and what is left as if the octahedron were
/// the affine one nearest to it. Refining linearly therefore changes no energy, as long as cells
/// are affine.
///
/// Units: with lengths in world units, entries have length^(3 - 2 K). Thread safe.
/// @param positions  of the level's vertices, world units
template <int K>
Eigen::SparseMatrix<double> massMatrix(const Complex& complex, const Array<Vec3>& positions);

}  // namespace octet
