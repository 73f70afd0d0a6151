// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "cell_tables.h"

namespace octet {

/// The thesis' free parameter: zeta = -5 is the only value at which the regular scheme reproduces
/// all quadratic 1-forms and all linear and quadratic 2-forms (SCHEME.md section 4).
inline constexpr double kDefaultZeta = -5.0;

/// @brief Linear (Whitney) subdivision inside one cell (SCHEME.md section 4, thesis 3.3 and 4.1) as
/// small matrices over the cell's own edges (lower to higher local vertex) and outward facets, and
/// on edges and facets of the coarse level.
struct LinearRules {
  explicit LinearRules(double zeta = kDefaultZeta);

  /// Weight of the two edges most nearly parallel to an octahedron's spoke: p = (zeta + 6) / 8.
  static double parallelWeight(double zeta) { return (zeta + 6) / 8; }

  /// 1-form on half an edge, 2-form on a quarter of a facet.
  static constexpr std::array<double, 1> kHalf = {1.0 / 2}, kQuarter = {1.0 / 4};
  /// 1-form on the edge in a facet (0,1,2) that cuts off corner k, from the midpoint towards the
  /// lower of the other corners to that towards the higher: 1/4 of the edge that it is parallel to,
  /// and of the two at the corner, over the edges kCutInputs in the order of summation.
  static constexpr int kCutInputs[4][2] = {{1, 2}, {0, 2}, {0, 1}, {1, 2}};
  static constexpr std::array<double, 4> kCut[3] = {{1.0 / 4, 1.0 / 4, -1.0 / 4, 0},
                                                    {1.0 / 4, 1.0 / 4, 1.0 / 4, 0},
                                                    {0, 1.0 / 4, 1.0 / 4, -1.0 / 4}};
  /// 1-form on the spoke from the centre to the midpoint of local edge k.
  std::array<std::array<double, 12>, 12> octSpoke;
  /// 2-form on facet (centre, xy, xz), in the order of the split: x ascending, then y < z.
  std::array<std::array<double, 8>, 24> octFacet;
  /// 2-form on the facet that cuts off local vertex k of a tetrahedron.
  std::array<std::array<double, 4>, 4> tetFacet;

  /// 3-form: a tetrahedron's share for each child tetrahedron and for the octahedron, then an
  /// octahedron's.
  static constexpr double kTetToTet = 1.0 / 8, kTetToOct = 1.0 / 2;
  static constexpr double kOctToTet = 1.0 / 32, kOctToOct = 1.0 / 8;
};

/// Sign of local triple (a,b,c) relative to the outward facet that has these vertices, and that
/// facet.
template <typename Shape>
constexpr std::array<int, 2> facetAndSign(int a, int b, int c) {
  for (int f = 0; f < Shape::kFacets; ++f) {
    const auto& t = Shape::facets[f];
    for (int k = 0; k < 3; ++k) {
      if (t[k] == a && t[(k + 1) % 3] == b && t[(k + 2) % 3] == c) return {f, 1};
      if (t[k] == a && t[(k + 1) % 3] == c && t[(k + 2) % 3] == b) return {f, -1};
    }
  }
  return {-1, 0};
}

}  // namespace octet
