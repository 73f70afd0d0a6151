// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// A star's vertices by label, and the weights with which they make the limit of a 0-form at its
/// centre, vertices[0].
struct StarLimit {
  std::vector<Index> vertices;
  std::shared_ptr<const Eigen::VectorXd> weights;
};

/// @brief Lists the limits at irregular interior vertices and at those in facets between two cells
/// of one kind (SCHEME.md section 6b). Empty for a control mesh, whose stars have each other's
/// moves in the first step.
std::vector<StarLimit> interiorLimits(const Complex& complex);

}  // namespace octet
