// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "complex.h"

namespace octet {

/// Two cells that share volume.
struct Overlap {
  Index cell, other;
};

/// @brief Looks for cells that overlap without sharing a facet: a vertex or a cell's centroid that
/// lies strictly inside another cell. Cells that fold over at a shared facet are found earlier,
/// from orientation; two cells that only cross with thin parts can escape.
std::optional<Overlap> findOverlap(const Complex& complex, const Array<Vec3>& positions);

}  // namespace octet
