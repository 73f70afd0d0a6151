// SPDX-License-Identifier: Apache-2.0
// The adjoint of refinement and limit: rows of influence against the forward operators.
#include <gtest/gtest.h>

#include <octet/core/field/field.h>
#include <octet/core/fit/influence.h>
#include <octet/core/forms/coboundary.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"
#include "tests/support/test_name.h"

namespace octet {
namespace {

using testing::NamedMesh;
using testing::testName;

constexpr double kTolerance = 1e-9;
constexpr Index kMostCells = 12000;

Refiner refine(const ControlMeshInput& input, int levels, bool smooth = true) {
  RefinerOptions options;
  options.levels = levels;
  options.smooth = smooth;
  return Refiner(ControlMesh::build(input), options);
}

/// Random coefficients, 0 where `zero` says so.
template <int K>
Cochain<K> randomFormBut(const Complex& complex, const std::vector<std::uint8_t>& zero,
                         std::uint32_t seed) {
  Cochain<K> form = testing::randomForm<K>(complex, seed);
  for (Index k = 0; k < form.size(); ++k) {
    if (zero[k]) form[k] = 0;
  }
  return form;
}

template <int K>
std::vector<std::uint8_t> boundarySimplices(const Complex& c) {
  std::vector<std::uint8_t> result(static_cast<std::size_t>(c.count(K)));
  for (Index k = 0; k < c.count(K); ++k) {
    result[k] = K == 1 ? c.edgeOnBoundary(k) : c.facetOnBoundary(k);
  }
  return result;
}

/// Points everywhere: random ones in cells, limit vertices of the boundary and inside.
std::vector<Vec3> samplePoints(const Refiner& refiner, const Limit& limit) {
  std::vector<Vec3> points;
  const Complex& c = refiner.finest();
  const auto r = testing::randomValues(1200, 5);
  for (int k = 0; k < 150; ++k) {
    const Index cell = static_cast<Index>((r[8 * k] + 1) / 2 * (c.cellCount() - 1));
    Vec3 p = Vec3::Zero();
    double sum = 0;
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      const double w = r[8 * k + 1 + i] + 1.01;
      p += w * limit.positions()[c.cellVertex(cell, i)];
      sum += w;
    }
    points.push_back(p / sum);
  }
  for (Index v = 0; v < c.vertexCount(); v += 1 + c.vertexCount() / 100) {
    points.push_back(limit.positions()[v]);
  }
  for (Index f = 0; f < c.facetCount(); f += 1 + c.facetCount() / 400) {
    if (!c.facetOnBoundary(f)) continue;
    Vec3 p = Vec3::Zero();
    for (const Index v : c.facetVertices(f)) p += limit.positions()[v] / 3;
    points.push_back(p);
  }
  return points;
}

/// Largest difference between rows and the sampled field, relative to the field.
template <int K>
double worstDifference(const Refiner& refiner, BoundaryMode mode,
                       const std::vector<std::uint8_t>& zero) {
  const Limit limit(refiner);
  const std::vector<Vec3> points = samplePoints(refiner, limit);
  const Influence<K> influence(refiner, limit, mode, zero);
  const auto rows = influence.at(points);
  double worst = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const Cochain<K> form = randomFormBut<K>(refiner.complex(0), zero, seed);
    const VectorField field = makeField(refiner, limit, refiner.refine(form, mode), mode);
    double scale = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
      Vec3 value;
      const bool inside = field.sample(points[k], &value);
      EXPECT_EQ(inside, rows.inside[k] != 0);
      if (!inside) continue;
      scale = std::max(scale, value.norm());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double row = rows.rows[3 * k + axis].apply(form.data());
        worst = std::max(worst, std::abs(row - value[static_cast<Index>(axis)]) / (1 + scale));
      }
    }
  }
  return worst;
}

class InfluenceOn : public ::testing::TestWithParam<NamedMesh> {};

TEST_P(InfluenceOn, AgreesWithRefinedField) {
  for (const int levels : {0, 1, 2}) {
    const Refiner refiner = refine(GetParam().input, levels);
    const Complex& c = refiner.complex(0);
    if (levels == 2 && refiner.finest().cellCount() > kMostCells) continue;  // for time
    for (const BoundaryMode mode : {BoundaryMode::Walls, BoundaryMode::Open}) {
      const std::vector<std::uint8_t> noEdge(static_cast<std::size_t>(c.edgeCount()), 0);
      const std::vector<std::uint8_t> noFacet(static_cast<std::size_t>(c.facetCount()), 0);
      EXPECT_LT(worstDifference<1>(refiner, mode, noEdge), kTolerance) << levels;
      EXPECT_LT(worstDifference<2>(refiner, mode, noFacet), kTolerance) << levels;
    }
    // Closed walls, where the limit is made tangential or normal.
    EXPECT_LT(worstDifference<1>(refiner, BoundaryMode::Walls, boundarySimplices<1>(c)), kTolerance)
        << levels;
    EXPECT_LT(worstDifference<2>(refiner, BoundaryMode::Walls, boundarySimplices<2>(c)), kTolerance)
        << levels;
  }
}

TEST_P(InfluenceOn, HoldsForSingleCoefficients) {
  const Refiner refiner = refine(GetParam().input, 1);
  const Complex& c = refiner.complex(0);
  const Limit limit(refiner);
  const std::vector<std::uint8_t> none(static_cast<std::size_t>(c.facetCount()), 0);
  const std::vector<Vec3> points = samplePoints(refiner, limit);
  for (const BoundaryMode mode : {BoundaryMode::Walls, BoundaryMode::Open}) {
    const auto rows = Influence<2>(refiner, limit, mode, none).at(points);
    for (Index f = 0; f < c.facetCount(); f += 1 + c.facetCount() / 12) {
      // What the limit does at a wall depends on which coefficients are 0: all but one are tiny.
      Cochain<2> unit(c), base(c);
      for (Index k = 0; k < c.facetCount(); ++k) unit[k] = base[k] = 1e-3;
      unit[f] += 1;
      const VectorField one = makeField(refiner, limit, refiner.refine(unit, mode), mode);
      const VectorField zero = makeField(refiner, limit, refiner.refine(base, mode), mode);
      for (std::size_t k = 0; k < points.size(); ++k) {
        Vec3 high, low;
        if (!one.sample(points[k], &high) || !zero.sample(points[k], &low)) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const SparseRow& row = rows.rows[3 * k + axis];
          const auto at = std::lower_bound(row.index.begin(), row.index.end(), f);
          const double entry = at != row.index.end() && *at == f
                                   ? row.weight[static_cast<std::size_t>(at - row.index.begin())]
                                   : 0;
          const Index i = static_cast<Index>(axis);
          EXPECT_NEAR(entry, high[i] - low[i], kTolerance * (1 + high.norm()));
        }
      }
    }
  }
}

TEST(Influence, OfLinearSubdivisionIsExactToo) {
  const Refiner refiner = refine(testing::withOctahedra(testing::randomBall(60, 3)), 2, false);
  const std::vector<std::uint8_t> noEdge(static_cast<std::size_t>(refiner.complex(0).edgeCount()));
  const std::vector<std::uint8_t> noFacet(
      static_cast<std::size_t>(refiner.complex(0).facetCount()));
  EXPECT_LT(worstDifference<1>(refiner, BoundaryMode::Open, noEdge), kTolerance);
  EXPECT_LT(worstDifference<2>(refiner, BoundaryMode::Open, noFacet), kTolerance);
}

/// S d = d S, in rows: a flux row of d A is the circulation row of A.
TEST(Influence, PullsBackDerivatives) {
  const Refiner refiner = refine(testing::withOctahedra(testing::randomBall(60, 4)), 2);
  const Complex& c = refiner.complex(0);
  const auto potential = testing::randomForm<1>(c, 8);
  const Cochain<2> flux = d(c, potential);
  std::vector<SparseRow> edges, facets;
  for (Index f = 0; f < refiner.finest().facetCount(); f += 37) {
    RowSum sum(refiner.finest().edgeCount());
    for (const EdgeRef& e : refiner.finest().facetEdges[f]) sum.add(e.index(), e.sign());
    edges.push_back(sum.take());
    facets.push_back({{f}, {1.0}});
  }
  const auto onEdges = RefinementAdjoint<1>(refiner, BoundaryMode::Open).pullBack(edges);
  const auto onFacets = RefinementAdjoint<2>(refiner, BoundaryMode::Open).pullBack(facets);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_NEAR(onEdges[k].apply(potential.data()), onFacets[k].apply(flux.data()), 1e-12);
  }
}

std::vector<NamedMesh> meshes() {
  std::vector<NamedMesh> result = testing::allKinds();
  for (NamedMesh& mesh : testing::randomMeshes()) result.push_back(std::move(mesh));
  return result;
}

INSTANTIATE_TEST_SUITE_P(Meshes, InfluenceOn, ::testing::ValuesIn(meshes()), testName);

}  // namespace
}  // namespace octet
