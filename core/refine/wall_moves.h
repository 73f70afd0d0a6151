// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "../topology/boundary.h"
#include "vertex_moves.h"

namespace octet {

/// @brief Appends the moves that the smooth wall adds to D1 L1 when a level that is not the control
/// mesh is split (SCHEME.md section 8b).
///
/// They depend on topology, creases and corners alone. Each star's rule is solved once per process.
/// @param coarse    the level that is split
/// @param boundary  of `coarse`
void wallMoves(const Complex& coarse, const Boundary& boundary, std::vector<StarMoves>* stars);

}  // namespace octet
