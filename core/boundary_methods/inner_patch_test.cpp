// SPDX-License-Identifier: Apache-2.0
#include "inner_patch_test.h"

#include <Eigen/QR>
#include <algorithm>

#include "../base/parallel.h"
#include "../forms/coboundary.h"

namespace octet {
namespace {

/// Residuals below this times the largest potential are rounding.
constexpr double kRounding = 1e-14;

/// One component of 1/2 x_a x x_b on all edges, the potential of a constant flux.
Cochain<1> potential(const Complex& c, const Array<Vec3>& x, const Vec3& origin, int axis) {
  Cochain<1> result(c);
  parallelFor<Index>(c.edgeCount(), [&](Index e) {
    const auto& [a, b] = c.edges[e];
    result[e] = (x[a] - origin).cross(x[b] - origin)[axis] / 2;
  });
  return result;
}

}  // namespace

InnerPatchTest::InnerPatchTest(const Refiner& refiner, int level, const Array<Vec3>& oldPositions,
                               const Array<Vec3>& newPositions)
    : c_(refiner.complex(level)), f_(refiner.complex(level + 1)), linear_(refiner.zeta()) {
  Array<Vec3> multipliers = residuals(refiner, level, oldPositions, newPositions);
  const auto wanted = [&](Index e) { return !multipliers[e].isZero(0); };
  Index any = 0;
  for (Index e = 0; e < f_.edgeCount(); ++e) any += wanted(e);
  if (any == 0) return;
  areas_.resize(f_.facetCount());
  for (int axis = 0; axis < 3; ++axis) {
    const auto coarse = d(c_, potential(c_, oldPositions, oldPositions[0], axis));
    const Cochain<2> fine = linear(coarse);
    for (Index f = 0; f < f_.facetCount(); ++f) areas_[f][axis] = fine[f];
  }
  parallelFor<Index>(f_.edgeCount(), [&](Index e) {
    if (!wanted(e)) return;
    const std::vector<Index> facets = facetsAround(e);
    Eigen::Matrix3Xd a(3, static_cast<Eigen::Index>(facets.size()));
    for (std::size_t k = 0; k < facets.size(); ++k) {
      a.col(static_cast<Eigen::Index>(k)) = areas_[facets[k]];
    }
    const Eigen::VectorXd row = a.completeOrthogonalDecomposition().solve(multipliers[e]);
    // Of least norm: in the span of the areas.
    multipliers[e] = a.transpose().completeOrthogonalDecomposition().solve(row);
  });
  for (Index e = 0; e < f_.edgeCount(); ++e) {
    if (wanted(e)) rows_.emplace_back(e, multipliers[e]);
  }
}

Array<Vec3> InnerPatchTest::residuals(const Refiner& refiner, int level,
                                      const Array<Vec3>& oldPositions,
                                      const Array<Vec3>& newPositions) const {
  // Potentials are quadratic in positions: measured from the middle they lose fewest digits.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : oldPositions) middle += p / static_cast<double>(oldPositions.size());
  Array<Vec3> result(f_.edgeCount(), Vec3::Zero());
  double scale = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto is =
        refiner.step(level, potential(c_, oldPositions, middle, axis), BoundaryMode::Walls);
    const auto should = potential(f_, newPositions, middle, axis);
    scale = std::max(scale, maxNorm(should.values()));
    for (Index e = 0; e < f_.edgeCount(); ++e) result[e][axis] = is[e] - should[e];
  }
  for (Index e = 0; e < f_.edgeCount(); ++e) {
    const auto& [a, b] = f_.edges[e];
    if (f_.vertexOnBoundary(a) || f_.vertexOnBoundary(b) ||
        result[e].cwiseAbs().maxCoeff() < kRounding * scale) {
      result[e].setZero();
    }
  }
  return result;
}

Cochain<2> InnerPatchTest::linear(const Cochain<2>& coarse) const {
  Cochain<2> result(f_);
  linear_.apply2(c_, coarse.data(), result.data());
  return result;
}

/// Facets of the cells around an edge, each once.
std::vector<Index> InnerPatchTest::facetsAround(Index edge) const {
  std::vector<Index> facets;
  f_.visitEdgeStar(edge, [&](const CellAtEdge& at) {
    for (int k = 0; k < f_.cellFacetCount(at.cell); ++k) {
      facets.push_back(f_.cellFacet(at.cell, k).index());
    }
  });
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  return facets;
}

void InnerPatchTest::correct(const Cochain<2>& coarse, Cochain<2>* fine) const {
  if (rows_.empty()) return;
  const Cochain<2> fluxes = linear(coarse);
  Cochain<1> potential(f_);
  parallelFor<std::size_t>(rows_.size(), [&](std::size_t k) {
    const auto& [edge, multiplier] = rows_[k];
    double sum = 0;
    for (const Index f : facetsAround(edge)) sum += multiplier.dot(areas_[f]) * fluxes[f];
    potential[edge] = sum;
  });
  const Cochain<2> correction = d(f_, potential);
  parallelFor<Index>(f_.facetCount(), [&](Index f) { (*fine)[f] -= correction[f]; });
}

}  // namespace octet
