// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "../topology/boundary.h"
#include "vertex_moves.h"

namespace octet {

/// @brief Lists the rows that the smooth wall adds to D1 L1 when a level that is not the control
/// mesh is split (SCHEME.md section 8b): a 0-form refines by S0 - H d0, H the matrix of these
/// entries. Entries of a row follow each other, rows ascend.
///
/// Depends on topology, creases and corners alone. Each star's rule is solved once per process.
/// @param coarse    the level that is split
/// @param boundary  of `coarse`
std::vector<VertexMove> wallMoves(const Complex& coarse, const Boundary& boundary);

}  // namespace octet
