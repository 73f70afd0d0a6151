// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../topology/complex.h"
#include "../topology/local_rows.h"

namespace octet {

/// @brief Damps moves that turn cells over, before the first levels have parted the stars of a
/// cage's irregular vertices (SCHEME.md section 6b): where a fine cell has a volume of its sign
/// without the moves and none with them, the moves of its vertices are halved, and dropped if that
/// is not enough after three times. What the moves do is linear in the rows, so that no identity
/// with d depends on it. Depends on positions alone: static for an animated asset.
///
/// @param moves   H1, damped in place
/// @param before  positions of the level that is split
/// @param after   positions with all moves made; corrected in place
void dampMoves(const Complex& fine, const Array<Vec3>& before, LocalRows* moves,
               Array<Vec3>* after);

}  // namespace octet
