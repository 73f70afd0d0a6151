// SPDX-License-Identifier: Apache-2.0
#include "potential_field.h"

#include "../base/parallel.h"
#include "../forms/coboundary.h"

namespace octet {
namespace {

/// The curl of l_x W_yz is k (3 l_x - 1) across the facet, where k is one over twice its area: with
/// coefficients a of sum 0 the normal velocity at corner i is k 3 a_i, and it shall be q_i / area.
constexpr double kPerVariation = 2.0 / 3;

double det(const std::array<Vec3, 4>& p) {
  return (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0]));
}

}  // namespace

PotentialField::PotentialField(std::shared_ptr<const Complex> complex, Array<Vec3> positions,
                               Cochain<1> potential, Array<Vec3> vectors, bool walls)
    : complex_(std::move(complex)),
      positions_(std::move(positions)),
      potential_(std::move(potential)),
      vectors_(std::move(vectors)),
      wallFacets_(static_cast<std::size_t>(complex_->facetCount()), 0) {
  for (Index e = 0; e < complex_->edgeCount(); ++e) {
    if (complex_->edgeOnBoundary(e) && potential_[e] != 0) zeroOnBoundary_ = false;
  }
  if (!walls) {
    zeroOnBoundary_ = false;  // the limit vectors cross the boundary
    return;
  }
  const double rounding = 1e-12 * maxNorm(potential_.values());
  for (Index f = 0; f < complex_->facetCount(); ++f) {
    if (!complex_->facetOnBoundary(f)) continue;
    double flux = 0;
    for (const EdgeRef& e : complex_->facetEdges[f]) flux += potential_.at(e);
    if (std::abs(flux) <= rounding) {
      wallFacets_[f] = 1;
    } else {
      zeroOnBoundary_ = false;
    }
  }
}

/// The facet functions of a piece, from the vectors at its corners.
void PotentialField::fillFacets(const std::array<Vec3, 4>& vectors, PotentialPiece* piece) const {
  for (int f = 0; f < 4; ++f) {
    const auto& t = Tetrahedron::facets[f];
    const auto& p = piece->points;
    const Vec3 area = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
    double through[3];
    for (int k = 0; k < 3; ++k) through[k] = vectors[t[k]].dot(area);
    const double mean = (through[0] + through[1] + through[2]) / 3;
    for (int k = 0; k < 3; ++k) piece->facets[f][k] = kPerVariation * (through[k] - mean);
  }
}

void PotentialField::visitPieces(Index cell, const Sink& sink) const {
  const Complex& c = *complex_;
  if (!c.isTet(cell)) return visitOctahedron(cell - c.tetCount(), sink);
  PotentialPiece piece;
  std::array<Vec3, 4> vectors;
  for (int i = 0; i < 4; ++i) {
    piece.points[i] = positions_[c.tets[cell][i]];
    vectors[i] = vectors_[c.tets[cell][i]];
  }
  for (int k = 0; k < 6; ++k) piece.edges[k] = potential_.at(c.tetEdge(cell, k));
  fillFacets(vectors, &piece);
  for (int f = 0; f < 4; ++f) {
    if (wallFacets_[c.tetFacets[cell][f].index()]) piece.facets[f].fill(0);
  }
  piece.sign = det(piece.points) * c.cellSigns[cell] < 0 ? -1 : 1;
  sink(piece);
}

void PotentialField::visitOctahedron(Index oct, const Sink& sink) const {
  const Complex& c = *complex_;
  const Index cell = c.tetCount() + oct;
  const auto& v = c.octs[oct];
  Vec3 centre = Vec3::Zero(), vector = Vec3::Zero();
  for (const Index i : v) {
    centre += positions_[i] / 6;
    vector += vectors_[i] / 6;
  }
  // A from the centre to corner i is s_i. Facet (centre, i, j) has the flux s_i + A_ij - s_j, which
  // shall be that of the vectors: least squares, a Laplace equation on the octahedron's graph.
  std::array<double, 12> along;
  std::array<double, 6> right{};
  for (int k = 0; k < 12; ++k) {
    const int i = Octahedron::edges[k][0], j = Octahedron::edges[k][1];
    along[k] = potential_.at(c.octEdge(oct, k));
    const Vec3 area = (positions_[v[i]] - centre).cross(positions_[v[j]] - centre) / 2;
    const double wanted = area.dot(vector + vectors_[v[i]] + vectors_[v[j]]) / 3 - along[k];
    right[i] += wanted;
    right[j] -= wanted;
  }
  // Its eigenvalues are 4 for what is odd between opposite corners, 6 for what is even, less the
  // mean, which is free.
  std::array<double, 6> spokes;
  for (int i = 0; i < 6; ++i) {
    const double other = right[Octahedron::opposite[i]];
    spokes[i] = (right[i] - other) / 8 + (right[i] + other) / 12;
  }

  PotentialPiece piece;
  piece.points[3] = centre;
  const auto& between = kCellTables<Octahedron>.edgeBetween;
  for (int f = 0; f < 8; ++f) {
    const auto& t = Octahedron::facets[f];
    std::array<Vec3, 4> vectors;
    vectors[3] = vector;
    for (int k = 0; k < 3; ++k) {
      piece.points[k] = positions_[v[t[k]]];
      vectors[k] = vectors_[v[t[k]]];
    }
    for (int k = 0; k < 6; ++k) {
      const int a = Tetrahedron::edges[k][0], b = Tetrahedron::edges[k][1];
      piece.edges[k] = b == 3        ? -spokes[t[a]]
                       : t[a] < t[b] ? along[between[t[a]][t[b]]]
                                     : -along[between[t[a]][t[b]]];
    }
    fillFacets(vectors, &piece);
    constexpr int kOuter = 3;  // facet (0, 2, 1), opposite the centre
    if (wallFacets_[c.octFacets[oct][f].index()]) piece.facets[kOuter].fill(0);
    // Outward facets make, with the centre, tetrahedra of the other orientation.
    piece.sign = det(piece.points) * c.cellSigns[cell] > 0 ? -1 : 1;
    sink(piece);
  }
}

}  // namespace octet
