// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../geometry/box_bins.h"
#include "complex.h"

namespace octet {

/// @brief Box around the cells of a complex; a vertex of no cell, which an asset may have, counts
/// for nothing.
inline Box domainBox(const Complex& complex, const Array<Vec3>& positions) {
  Box box;
  for (const auto& [a, b] : complex.edges) {
    box.extend(positions[a]);
    box.extend(positions[b]);
  }
  return box;
}

}  // namespace octet
