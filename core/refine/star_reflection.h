// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// @brief Finds the reflection of a vertex' star that exchanges two vertices a and b, the ends of
/// its axis (SCHEME.md section 6b).
/// @return pairs (vertex, image), ascending; none if there is no such reflection
std::optional<std::vector<std::pair<Index, Index>>> starReflection(const Complex& complex,
                                                                   Index centre, Index a, Index b);

}  // namespace octet
