// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "../topology/local_rows.h"
#include "../topology/star_walk.h"

namespace octet {

/// @file
/// Entries of a sparse matrix H1 from coarse edges to fine vertices, which the rules for irregular
/// stars add to D1 L1: a 0-form refines by S0 - H1 d0 (SCHEME.md section 6b).

/// @brief What the rule of one irregular star asks of the children around it, as rows of H1.
/// Children that several stars ask for get the sum inside, and the mean at walls.
struct StarMoves {
  struct Term {
    Index coarseEdge;
    double weight;  ///< along the edge's stored direction
  };
  bool atWall = false;
  std::vector<Index> children;     ///< fine vertices
  std::vector<std::size_t> begin;  ///< of each child's terms, and their end
  std::vector<Term> terms;

  /// Appends what moves the child in the place of label `a` by sum_q weights[q] (q - m).
  template <typename Weights>
  void add(const StarPaths& paths, int a, const Weights& weights);
};

/// Makes rows of the moves of stars. They depend on nothing but the moves, whatever their order.
LocalRows moveRows(const std::vector<StarMoves>& stars);

/// @brief Leaves out stars whose moves spoil cells, since irregular stars overlap in the first
/// splits, and since a smooth wall flattens cells beside it: a fine cell that a star has a hand in
/// must keep a share of the volume that it has without moves, and must not be turned over without
/// them (SCHEME.md section 6b). The criterion does not change under affine maps; it depends on
/// positions alone, so that it is static for an animated asset.
/// @param level   of `fine`: stars inside are only looked at in the first splits
/// @param before  positions of the level that is split
/// @param after   positions without moves; with those of the stars that are left on return
std::vector<StarMoves> soundMoves(const Complex& fine, int level, const Array<Vec3>& before,
                                  std::vector<StarMoves> stars, Array<Vec3>* after);

/// Weights below this are nothing.
inline constexpr double kNoMove = 1e-15;

template <typename Weights>
void StarMoves::add(const StarPaths& paths, int a, const Weights& weights) {
  std::vector<double> sums(paths.edges().size(), 0.0);
  bool any = false;
  for (Eigen::Index q = 1; q < weights.size(); ++q) {
    const double weight = weights[q];
    if (std::abs(weight) < kNoMove) continue;
    any = true;
    paths.visit(static_cast<int>(q),
                [&](std::size_t edge, double share) { sums[edge] -= weight * share; });
  }
  if (!any) return;
  if (begin.empty()) begin.push_back(0);
  children.push_back(paths.place(a));
  for (std::size_t e = 0; e < sums.size(); ++e) {
    if (std::abs(sums[e]) > kNoMove) terms.push_back({paths.edges()[e], sums[e]});
  }
  begin.push_back(terms.size());
}

}  // namespace octet
