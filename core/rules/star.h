// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

/// @file
/// Stars of vertices by labels alone, and the matrix by which one subdivision maps a star to the
/// star of the same vertex one level finer.

namespace octet {

/// @brief Describes the cells around a vertex by labels: 0 is the vertex m itself. Equal stars of
/// any mesh compare equal when they are labelled alike.
struct Star {
  int vertexCount = 0;                            ///< labels are 0..vertexCount-1
  std::vector<std::array<std::uint8_t, 4>> tets;  ///< labels ascend
  std::vector<std::array<std::uint8_t, 6>> octs;  ///< as Octahedron (cell_tables.h) from m on

  int cellCount() const { return static_cast<int>(tets.size() + octs.size()); }
  bool isTet(int cell) const { return cell < static_cast<int>(tets.size()); }
  const std::array<std::uint8_t, 6>& oct(int cell) const { return octs[cell - tets.size()]; }

  bool operator<(const Star& other) const;
};

/// Lists the cells at the edge from m to a label, tetrahedra first; an octahedron in which the
/// label is opposite m does not count.
std::vector<int> cellsAtEdge(const Star& star, int label);

/// Is there an edge from m to the label?
bool adjacentToCentre(const Star& star, int label);

/// @brief Computes the matrix of a star by the rule for 0-forms inside (SCHEME.md section 6):
/// row a is the child in the place of label a (m itself; the midpoint of (m,a); the centre of the
/// octahedron in which a is opposite m) as a combination of the star's vertices. Only rows from
/// label `first` on are filled.
Eigen::MatrixXd starMatrix(const Star& star, int first = 0);

/// @brief Computes the weights of a star's vertices in the limit at m: the left eigenvector of the
/// star's matrix for the simple eigenvalue 1, whose sum is 1.
Eigen::VectorXd limitWeights(const Eigen::MatrixXd& matrix);

/// Computes an orthonormal basis of the invariant subspace of a real matrix for all eigenvalues
/// whose modulus is above a bound.
Eigen::MatrixXd invariantSubspace(const Eigen::MatrixXd& matrix, double above);

}  // namespace octet
