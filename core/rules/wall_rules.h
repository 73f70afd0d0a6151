// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "star.h"

/// @file
/// The smooth wall: rules for positions in the stars of boundary vertices (SCHEME.md section
/// 8b), which put the leading eigenvalues of a star's matrix at 1/2 and hold the others down, so
/// that neither the wall's curvature nor the flux beside it grows from level to level.
///
/// A wall star is labelled: 0 is the boundary vertex m itself, 1..n its ring on the wall,
/// counterclockwise seen from outside, and the rest lie inside or beyond the ring. A rule is a
/// matrix of weights over labels: the child in the place of label a (the midpoint of (m,a), the
/// centre of the octahedron where a is opposite m, m itself) moves by
/// sum_q weights(a, q) (q - m). Rows sum to zero.

namespace octet {

/// @brief Describes the star of a smooth boundary vertex: labels 1..valence are its ring.
struct WallStar {
  Star star;
  int valence = 0;  ///< n, the number of wall edges at m

  bool operator<(const WallStar& other) const;
};

/// Gives the weight of each ring vertex in m's own new position: beta = 3/(8n) at a smooth wall
/// vertex of valence n != 6, Loop's elsewhere.
double smoothWallBeta(int valence);

/// Computes w_j for j = 0..n-1: the child of (m, r_i) moves by sum_j w_{j-i} r_j on a smooth wall
/// of valence n. The first harmonic goes to 1/2, the second to 1/4, higher ones to 1/5 at most.
std::vector<double> wallRingMoves(int valence);

/// Computes all moves of a wall star (items 1 to 3 of section 8b); a matrix of zeros where the star
/// is regular, or where the rule would exceed what the section allows.
Eigen::MatrixXd wallStarMoves(const WallStar& star);

}  // namespace octet
