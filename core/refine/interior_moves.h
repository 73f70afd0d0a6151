// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "../rules/interior_rules.h"
#include "irregular_stars.h"
#include "vertex_moves.h"

namespace octet {

/// @brief Lists what irregular interior stars add to D1 L1 when a level is split: H1 of SCHEME.md
/// section 6b. Each star's rule is solved once per process.
std::vector<StarMoves> interiorMoves(const IrregularStars& stars);

/// Does an irregular interior vertex' star fold when subdivision settles its shape (InteriorRule)?
bool starFolds(const IrregularStars& stars, Index vertex);

}  // namespace octet
