// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "../field/piece_source.h"
#include "../forms/cochain.h"

namespace octet {

/// A tetrahedron with a vector potential on it that is quadratic: with barycentric coordinates l,
/// their gradients g and W_ij = l_i g_j - l_j g_i,
///   A = sum over edges ij of edges[ij] W_ij + sum over facets (x, y, z) of
///       facets[.][0] l_x W_yz + facets[.][1] l_y W_zx + facets[.][2] l_z W_xy.
struct PotentialPiece {
  std::array<Vec3, 4> points;
  std::array<double, 6> edges;                  ///< integrals, lower to higher corner
  std::array<std::array<double, 3>, 4> facets;  ///< by facet and place of Tetrahedron::facets
  double sign;                                  ///< -1 for a piece turned inside out
};

/// @brief A vector potential whose curl is an accurate velocity: second order, without divergence
/// at any point, with exactly the fluxes of a 2-form (SCHEME.md section 9).
///
/// The Whitney form of A has the right circulations, but its curl is constant between facets, only
/// first-order accurate. Facet functions l_x W_yz, which vanish along all edges, add what the
/// normal velocity varies over a facet by, taken from the limit vectors at its corners: in each
/// tetrahedron the curl is then the one linear field without divergence that has these facet fluxes
/// and variations (the BDM element; Brezzi, Douglas, Marini 1985), and it reproduces linear fields.
/// What gradient A contains does not matter. An octahedron is eight tetrahedra around its centroid;
/// A on the six spokes is what fits the limit vectors' fluxes through the facets between them best.
/// Immutable; thread safe.
class PotentialField {
 public:
  /// @param positions  of the complex' vertices: those that coefficients refer to
  /// @param potential  A on the edges
  /// @param vectors    limit vectors of d A at the vertices
  /// @param walls      boundary facets where d A is 0 are walls: nothing crosses them at any point
  PotentialField(std::shared_ptr<const Complex> complex, Array<Vec3> positions,
                 Cochain<1> potential, Array<Vec3> vectors, bool walls);

  const Complex& complex() const { return *complex_; }
  const Array<Vec3>& positions() const { return positions_; }
  /// Is A zero along the whole boundary? Then it may be continued by zero.
  bool zeroOnBoundary() const { return zeroOnBoundary_; }

  using Sink = std::function<void(const PotentialPiece&)>;
  /// Calls `sink` for the pieces of a cell: one, or eight of an octahedron.
  void visitPieces(Index cell, const Sink& sink) const;

 private:
  void fillFacets(const std::array<Vec3, 4>& vectors, PotentialPiece* piece) const;
  void visitOctahedron(Index oct, const Sink& sink) const;

  std::shared_ptr<const Complex> complex_;
  Array<Vec3> positions_;
  Cochain<1> potential_;
  Array<Vec3> vectors_;
  std::vector<std::uint8_t> wallFacets_;  // 1 where nothing crosses
  bool zeroOnBoundary_ = true;
};

}  // namespace octet
