// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cmath>

#include "../base/numbers.h"

/// @file
/// The numbers of the smoothing homotopy on any mesh (SCHEME.md section 6) and of the wall surface
/// (section 8).

namespace octet {

/// D1 of an interior vertex, per cell of its star and divided by their number; from the per-cell
/// stencils of the thesis' Fig. 2.13. In an octahedron the ring vertices u have two weights: on
/// (v,u), and on (u, opposite of v).
inline constexpr double kTetVertexWeight = 17.0 / 48;
inline constexpr double kOctVertexWeight = 15.0 / 96;
inline constexpr double kOctRingWeight = 7.0 / 96;

/// D2 of an interior edge (u,v), per cell of its star and divided by their number. In a tetrahedron
/// kTetEdgeWeight on (u,v,w) for both other vertices w; in an octahedron, with U, W opposite u, v
/// and p off their square, on (u,v,p), on (u,W,p) and (U,v,p), and on (U,W,p).
inline constexpr double kTetEdgeWeight = 1.0 / 2;
inline constexpr std::array<double, 3> kOctEdgeWeights = {1.0 / 2, -1.0 / 4, 1.0 / 16};

/// D3 of an interior facet, on the cells beside it; 4:1 keeps a constant density.
inline constexpr double kTetFacetWeight = 1.0 / 5;
inline constexpr double kOctFacetWeight = 1.0 / 20;

/// D1 of a crease vertex, on its two crease edges: cubic B-spline.
inline constexpr double kCreaseWeight = 1.0 / 4;

/// D2 of a boundary edge with an irregular end, on (u,v,w) of its two boundary facets.
inline constexpr double kBoundaryEdgeWeight = 1.0 / 4;

/// Half of D1's weight on each edge of a smooth boundary vertex of valence n: Loop's scheme.
inline double loopBeta(int valence) {
  const double c = 3.0 / 8 + std::cos(2 * kPi / valence) / 4;
  return (5.0 / 8 - c * c) / valence;
}

/// One term of D2 of a boundary edge (u,v) between vertices of valence 6: the triangle at u (or v)
/// between directions `direction` and `direction + 1`, counted in sixths of a turn from v - u.
struct SurfaceTerm {
  bool atEnd;
  int direction;
  double weight;
};

/// The 2-chain of least norm from such an edge to the average of its translates in the triangular
/// lattice (1/4 itself, 1/8 each of six); with the linear rule this is the 2D scheme of Wang et al.
/// (thesis Fig. 1.4).
inline constexpr std::array<SurfaceTerm, 6> kSurfaceEdgeTerms = {{{false, 0, 1.0 / 4},
                                                                  {false, 1, 1.0 / 8},
                                                                  {false, 4, -1.0 / 8},
                                                                  {false, 5, -1.0 / 4},
                                                                  {true, 1, 1.0 / 8},
                                                                  {true, 4, -1.0 / 8}}};

/// Damping of the patch test on walls (SCHEME.md section 8): weak = kWallDamping * max(s).
inline constexpr double kWallDamping = 0.04;

}  // namespace octet
