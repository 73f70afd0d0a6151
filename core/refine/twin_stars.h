// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "irregular_stars.h"

namespace octet {

/// @brief Finds the vertices in facets between two cells of one kind whose star is the lattice on
/// one side and its mirror image on the other (SCHEME.md section 6c).
/// @return their vertices by the labels of twinFluxes(), in ascending order of the centres
std::vector<std::vector<Index>> twinStars(const IrregularStars& stars);

}  // namespace octet
