// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

/// @file
/// The flux rules at irregular stars as small matrices over labels, all images of the tables' rows
/// under the stars' symmetries (SCHEME.md sections 6b and 6c).

namespace octet {

/// @brief Holds what a star's rule adds to D2 L2 of the fine edges in the places of the star's
/// edges, from the fluxes through the star's facets.
struct FluxPattern {
  struct Term {
    std::uint16_t edge, facet;  ///< numbers in the lists below
    double weight;
  };
  std::vector<std::array<std::uint8_t, 2>>
      edges;  ///< ascending labels, which orient them; in order
  std::vector<std::array<std::uint8_t, 3>> facets;  ///< likewise
  std::vector<Term> terms;                          ///< edges ascend
};

/// The pattern at a vertex on a line of n tetrahedra, n = 3..12; labels are m 0, a 1, b 2,
/// r_j 3 + j, s_j 3 + n + j, o_j 3 + 2n + j. Empty for any other n.
const FluxPattern& lineFluxes(int tetrahedra);

/// The pattern at a vertex in a facet between two cells of one kind; labels are m 0, r_j 1 + j,
/// u_k 7 + k, w_k 10 + k, p_k 13 + k, q_k 16 + k.
const FluxPattern& twinFluxes();

}  // namespace octet
