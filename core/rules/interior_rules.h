// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "star.h"

/// @file
/// Moves of positions in the stars of irregular vertices inside (SCHEME.md section 6b). The
/// child in the place of label a moves by sum_q weights(a, q) (q - m), so that the star shrinks by
/// 1/2 per level in all three directions, as the rules for fluxes suppose.

namespace octet {

/// @brief Describes the star of an irregular interior vertex. On a line the reflection exchanges
/// the two ends of the axis.
struct InteriorStar {
  Star star;
  bool onLine = false;               ///< X2; otherwise X3
  std::vector<std::uint8_t> mirror;  ///< image of each label; empty off lines
  std::uint8_t axis[2] = {0, 0};     ///< ends of the axis; 0 off lines

  bool operator<(const InteriorStar& other) const;
};

/// @brief Lists the moves at a vertex on a line of n >= 3 tetrahedra, in closed form: the child of
/// (m, r_i) moves by sum_j ring[j-i] (r_j + s_j - 2m) + beyond[j-i] (o_j - m), indices modulo n.
struct LineMoves {
  std::vector<double> ring, beyond;
};
LineMoves lineMoves(int tetrahedra);

/// @brief Holds the rule of an irregular star.
struct InteriorRule {
  /// None where the section's conditions are not met. Rows sum to zero; only rows of vertices
  /// adjacent to m and off the axis are filled.
  std::optional<Eigen::MatrixXd> moves;
  /// Weights of the star's vertices in the limit of a 0-form at m.
  Eigen::VectorXd limit;
  /// Does the shape that subdivision brings the star to, up to an affine map, fold? Then cells
  /// beside m are turned over at fine levels, whatever the control positions.
  bool folds = false;
};

/// Computes the rule of a star by assigning its matrix' eigenvalues.
InteriorRule interiorRule(const InteriorStar& star);

/// Computes the rule at a vertex on a line of n >= 3 tetrahedra from lineMoves(). Labels are those
/// of lineFluxes().
InteriorRule lineRule(int tetrahedra);

/// Computes the weights in the limit at a vertex in a facet between two cells of one kind. Labels
/// are those of twinFluxes().
Eigen::VectorXd twinLimit();

}  // namespace octet
