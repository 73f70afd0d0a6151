// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "../base/context.h"
#include "complex.h"

namespace octet {

/// Two cells that share volume.
struct Overlap {
  Index cell, other;
};

/// @brief Looks for cells that overlap, whether or not they share vertices, and returns the first
/// one that overlaps an earlier one. An octahedron so concave that no diagonal splits it into
/// tetrahedra, nor its centroid, is not looked at.
std::optional<Overlap> findOverlap(const Complex& complex, const Array<Vec3>& positions,
                                   const Context& context = {});

}  // namespace octet
