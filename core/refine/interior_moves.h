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

/// A star's vertices by label, and the weights with which they make the limit of a 0-form at its
/// centre, vertices[0].
struct StarLimit {
  std::vector<Index> vertices;
  std::shared_ptr<const Eigen::VectorXd> weights;
};

/// @brief Lists the limits at irregular interior vertices and at those in facets between two cells
/// of one kind. Empty for a control mesh, whose stars have each other's moves in the first step.
std::vector<StarLimit> interiorLimits(const Complex& complex);

/// Does an irregular interior vertex' star fold when subdivision settles its shape (InteriorRule)?
bool starFolds(const IrregularStars& stars, Index vertex);

}  // namespace octet
