// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

/// @file
/// The two cell shapes of an octet complex, as tables of local indices (SCHEME.md section 2, thesis
/// Figs 3.1 and 3.2 counted from 0). Everything else about a cell is derived from them.

namespace octet {

/// Permutations of three places: even ones first, so that `p < 3` is "keeps the orientation".
inline constexpr std::uint8_t kPermutations[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                                     {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

/// The permutation that sends 0 to `p0`, 1 to `p1` and 2 to the place left over.
constexpr std::uint8_t permutationOf(int p0, int p1) {
  for (std::uint8_t p = 0; p < 6; ++p) {
    if (kPermutations[p][0] == p0 && kPermutations[p][1] == p1) return p;
  }
  return 0;
}

/// Tetrahedron (v0 v1 v2 v3).
struct Tetrahedron {
  static constexpr int kVertices = 4, kEdges = 6, kFacets = 4;
  static constexpr std::uint8_t edges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  /// Outward for a positively oriented tetrahedron.
  static constexpr std::uint8_t facets[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
};

/// Octahedron (v0; v1 v2 v3 v4; v5): poles v0 and v5, ring v1..v4.
struct Octahedron {
  static constexpr int kVertices = 6, kEdges = 12, kFacets = 8;
  /// The pairs that are not opposite, in lexicographic order.
  static constexpr std::uint8_t edges[12][2] = {{0, 1}, {0, 2}, {0, 3}, {0, 4}, {1, 2}, {1, 4},
                                                {1, 5}, {2, 3}, {2, 5}, {3, 4}, {3, 5}, {4, 5}};
  /// Outward for a positively oriented octahedron.
  static constexpr std::uint8_t facets[8][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1},
                                                {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}};
  static constexpr std::uint8_t opposite[6] = {5, 3, 4, 1, 2, 0};
};

/// Where a local edge (i,j), i < j, lies in the facets of its cell.
struct EdgeInFacet {
  std::uint8_t facet;       ///< local facet
  std::uint8_t start, end;  ///< places of i and j in the facet's vertex triple
  std::int8_t sign;         ///< +1 when the facet's boundary runs from i to j
};

/// Tables derived from a shape's edges and facets.
template <typename Shape>
struct CellTables {
  /// Local edge between two local vertices, or -1.
  std::int8_t edgeBetween[Shape::kVertices][Shape::kVertices]{};
  /// The two facets of a local edge.
  EdgeInFacet edgeFacets[Shape::kEdges][2]{};

  constexpr CellTables() {
    for (auto& row : edgeBetween) {
      for (auto& e : row) e = -1;
    }
    for (int e = 0; e < Shape::kEdges; ++e) {
      const int i = Shape::edges[e][0], j = Shape::edges[e][1];
      edgeBetween[i][j] = edgeBetween[j][i] = static_cast<std::int8_t>(e);
      int found = 0;
      for (std::uint8_t f = 0; f < Shape::kFacets; ++f) {
        int start = -1, end = -1;
        for (int k = 0; k < 3; ++k) {
          if (Shape::facets[f][k] == i) start = k;
          if (Shape::facets[f][k] == j) end = k;
        }
        if (start < 0 || end < 0) continue;
        edgeFacets[e][found++] = {f, static_cast<std::uint8_t>(start),
                                  static_cast<std::uint8_t>(end),
                                  static_cast<std::int8_t>((start + 1) % 3 == end ? 1 : -1)};
      }
    }
  }
};

template <typename Shape>
inline constexpr CellTables<Shape> kCellTables{};

}  // namespace octet
