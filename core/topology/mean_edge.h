// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "complex.h"

namespace octet {

/// Mean length of a complex' edges, in the positions' units; 0 when there are none.
inline double meanEdge(const Complex& complex, const Array<Vec3>& positions) {
  double sum = 0;
  for (const auto& [a, b] : complex.edges) sum += (positions[b] - positions[a]).norm();
  return complex.edges.empty() ? 0 : sum / static_cast<double>(complex.edges.size());
}

}  // namespace octet
