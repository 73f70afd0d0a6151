// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "../topology/star_walk.h"

namespace octet {

/// One entry of a sparse matrix H from coarse edges to fine vertices, which the rules for irregular
/// stars add to D1 L1: a 0-form refines by S0 - H d0 (SCHEME.md section 6b).
struct VertexMove {
  Index fineVertex;
  Index coarseEdge;
  double weight;  ///< along the edge's stored direction
};

/// Weights below this are nothing.
inline constexpr double kNoMove = 1e-15;

/// Appends what moves the child in the place of label `a` by sum_q weights[q] (q - m).
template <typename Weights>
void addMoves(const StarPaths& paths, int a, const Weights& weights,
              std::vector<VertexMove>* moves) {
  for (Eigen::Index q = 1; q < weights.size(); ++q) {
    const double weight = weights[q];
    if (std::abs(weight) < kNoMove) continue;
    paths.visit(static_cast<int>(q), [&](EdgeRef e, double share) {
      moves->push_back({paths.place(a), e.index(), -weight * share * e.sign()});
    });
  }
}

}  // namespace octet
