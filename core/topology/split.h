// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "complex.h"

namespace octet {

/// @brief Topological split (SCHEME.md section 3, thesis Figs 1.6 and 1.7): a tetrahedron into 4
/// corner tetrahedra and 1 octahedron, an octahedron into 6 corner octahedra and 8 tetrahedra
/// around its centre. Children are numbered in closed form: no search, no hashing, no sorting.
/// @throws InputError when the fine level would have more simplices than indices can tell apart.
std::shared_ptr<const Complex> split(const std::shared_ptr<const Complex>& coarse);

}  // namespace octet
