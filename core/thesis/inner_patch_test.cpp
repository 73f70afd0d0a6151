// SPDX-License-Identifier: Apache-2.0
#include "inner_patch_test.h"

#include <Eigen/QR>
#include <algorithm>

#include "../base/parallel.h"
#include "../forms/coboundary.h"
#include "../refine/patch_test.h"

namespace octet {
namespace {

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
    const std::vector<Index> facets = facetsAround(f_, e);
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
  Array<Vec3> result = patchTestResiduals(
      f_,
      [&](const double* coarse, double* fine) {
        const Cochain<1> form(Array<double>(coarse, coarse + c_.edgeCount()));
        const Cochain<1> refined = refiner.step(level, form, BoundaryMode::Walls);
        std::copy(refined.values().begin(), refined.values().end(), fine);
      },
      oldPositions, newPositions);
  for (Index e = 0; e < f_.edgeCount(); ++e) {
    const auto& [a, b] = f_.edges[e];
    if (f_.vertexOnBoundary(a) || f_.vertexOnBoundary(b)) result[e].setZero();
  }
  return result;
}

Cochain<2> InnerPatchTest::linear(const Cochain<2>& coarse) const {
  Cochain<2> result(f_);
  linear_.apply2(c_, coarse.data(), result.data());
  return result;
}

void InnerPatchTest::correct(const Cochain<2>& coarse, Cochain<2>* fine) const {
  if (rows_.empty()) return;
  const Cochain<2> fluxes = linear(coarse);
  Cochain<1> potential(f_);
  parallelFor<std::size_t>(rows_.size(), [&](std::size_t k) {
    const auto& [edge, multiplier] = rows_[k];
    double sum = 0;
    for (const Index f : facetsAround(f_, edge)) sum += multiplier.dot(areas_[f]) * fluxes[f];
    potential[edge] = sum;
  });
  const Cochain<2> correction = d(f_, potential);
  parallelFor<Index>(f_.facetCount(), [&](Index f) { (*fine)[f] -= correction[f]; });
}

}  // namespace octet
