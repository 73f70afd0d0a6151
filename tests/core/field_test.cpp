// SPDX-License-Identifier: Apache-2.0
// Fields rebuilt from coefficients: Whitney forms, limits, sampling and rasterising.
#include <algorithm>
#include <map>
#include <mutex>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/core/field/field.h>
#include <octet/core/field/whitney.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/raster/rasterizer.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"
#include "tests/support/test_name.h"

namespace octet {
namespace {

using testing::NamedMesh;
using testing::randomForm;
using testing::testName;

Refiner refine(const ControlMeshInput& input, int levels) {
  RefinerOptions options;
  options.levels = levels;
  return Refiner(ControlMesh::build(input), options);
}

/// Random points in the bounding box of some positions.
std::vector<Vec3> randomPoints(const Array<Vec3>& positions, std::size_t count) {
  Box box;
  for (const Vec3& p : positions) box.extend(p);
  const auto r = testing::randomValues(static_cast<Index>(3 * count), 77);
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < count; ++k) {
    const Vec3 unit(r[3 * k], r[3 * k + 1], r[3 * k + 2]);
    points.push_back(box.min + ((unit + Vec3::Ones()) / 2).cwiseProduct(box.size()));
  }
  return points;
}

// ---- Whitney forms ------------------------------------------------------------------------------

/// Convex cells: in others pieces of an octahedron overlap.
std::vector<NamedMesh> convexMeshes() {
  std::vector<NamedMesh> result;
  for (NamedMesh& mesh : testing::allKinds()) {
    const bool keep = mesh.name.find("mixed") == std::string::npos &&
                      mesh.name.find("concave") == std::string::npos;
    if (keep) result.push_back(std::move(mesh));
  }
  return result;
}

class WhitneyOn : public ::testing::TestWithParam<NamedMesh> {};

/// Integrals of a field over an edge and over a facet, by sampling just inside a cell.
Vec3 shrunk(const Vec3& p, const Vec3& towards) { return p + 1e-7 * (towards - p); }

TEST_P(WhitneyOn, IntegratesToItsCoefficients) {
  const ControlMesh mesh = ControlMesh::build(GetParam().input);
  const auto complex = mesh.complex();
  const Complex& c = *complex;
  const auto one = randomForm<1>(c, 1);
  const auto two = randomForm<2>(c, 2);
  const VectorField field1(std::make_shared<Whitney<1>>(complex, mesh.positions(), one));
  const VectorField field2(std::make_shared<Whitney<2>>(complex, mesh.positions(), two));
  const GaussRule rule(6);
  const auto& x = mesh.positions();
  for (Index cell = 0; cell < std::min(c.cellCount(), Index{60}); ++cell) {
    Vec3 centroid = Vec3::Zero();
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      centroid += x[c.cellVertex(cell, i)] / c.cellVertexCount(cell);
    }
    // In an octahedron the pieces are linear between midpoints: integrate each half, and check the
    // facets by their quarters.
    const double tolerance = c.isTet(cell) ? 1e-5 : 2e-2;
    for (int k = 0; k < c.cellFacetCount(cell); ++k) {
      const Index facet = c.cellFacet(cell, k).index();
      const auto v = c.facetVertices(facet);
      for (int j = 0; j < 3; ++j) {
        const Vec3 a = shrunk(x[v[j]], centroid), b = shrunk(x[v[(j + 1) % 3]], centroid);
        double sum = 0;
        constexpr int kParts = 64;
        for (int part = 0; part < kParts; ++part) {
          for (std::size_t n = 0; n < rule.points.size(); ++n) {
            Vec3 value;
            ASSERT_TRUE(field1.sample(a + (part + rule.points[n]) / kParts * (b - a), &value));
            sum += rule.weights[n] / kParts * value.dot(b - a);
          }
        }
        EXPECT_NEAR(sum, one.at(c.facetEdge(facet, j, (j + 1) % 3)), tolerance);
      }
      const Vec3 a = shrunk(x[v[0]], centroid), b = shrunk(x[v[1]], centroid),
                 d = shrunk(x[v[2]], centroid);
      double flux = 0;
      constexpr int kRows = 24;
      for (int i = 0; i < kRows; ++i) {
        for (int j = 0; i + j < kRows; ++j) {
          for (const bool up : {true, false}) {
            if (!up && i + j + 1 >= kRows) continue;
            const double s = (i + (up ? 1.0 : 2.0) / 3) / kRows;
            const double t = (j + (up ? 1.0 : 2.0) / 3) / kRows;
            Vec3 value;
            ASSERT_TRUE(field2.sample(a + s * (b - a) + t * (d - a), &value));
            flux += value.dot((b - a).cross(d - a)) / 2 / (kRows * kRows);
          }
        }
      }
      EXPECT_NEAR(flux, two[facet], c.isTet(cell) ? 1e-5 : 3e-2);
    }
  }
}

TEST_P(WhitneyOn, ConstantsAreExactEverywhere) {
  const ControlMesh mesh = ControlMesh::build(GetParam().input);
  const DeRham rham(*mesh.complex(), mesh.positions(), 1);
  const Vec3 constant(0.3, -1.2, 0.7);
  const auto field = [&](const Vec3&) { return constant; };
  const auto density = [](const Vec3&) { return 2.5; };
  const VectorField field1(
      std::make_shared<Whitney<1>>(mesh.complex(), mesh.positions(), rham.edges(field)));
  const VectorField field2(
      std::make_shared<Whitney<2>>(mesh.complex(), mesh.positions(), rham.facets(field)));
  const ScalarField field3(
      std::make_shared<Whitney<3>>(mesh.complex(), mesh.positions(), rham.cells(density)));
  int inside = 0;
  for (const Vec3& p : randomPoints(mesh.positions(), 500)) {
    Vec3 value;
    Piece<1>::Value scalar;
    if (!field1.sample(p, &value)) continue;
    ++inside;
    EXPECT_LT((value - constant).norm(), 1e-12);
    ASSERT_TRUE(field2.sample(p, &value));
    // The linear 2-form rule reproduces constants on affine octahedra only.
    const bool affine = GetParam().name.find("deformed") == std::string::npos;
    EXPECT_LT((value - constant).norm(), affine ? 1e-12 : 0.2);
    ASSERT_TRUE(field3.sample(p, &scalar));
    if (affine) {
      EXPECT_NEAR(scalar[0], 2.5, 1e-12);
    }
  }
  EXPECT_GT(inside, 20);
}

INSTANTIATE_TEST_SUITE_P(Meshes, WhitneyOn, ::testing::ValuesIn(convexMeshes()), testName);

// ---- Limits -------------------------------------------------------------------------------------

class LimitOn : public ::testing::TestWithParam<NamedMesh> {};

TEST_P(LimitOn, ConstantsAreExactAtEveryVertex) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Limit limit(refiner);
  const DeRham rham(refiner.finest(), refiner.positions(2), 1);
  const Vec3 constant(0.3, -1.2, 0.7);
  const auto field = [&](const Vec3&) { return constant; };
  const auto v1 = limit.vectors(rham.edges(field), BoundaryMode::Open);
  const auto v2 = limit.vectors(rham.facets(field), BoundaryMode::Open);
  const auto rho = limit.densities(rham.cells([](const Vec3&) { return 2.5; }));
  for (Index v = 0; v < refiner.finest().vertexCount(); ++v) {
    EXPECT_LT((v1[v] - constant).norm(), 1e-9) << "vertex " << v;
    EXPECT_LT((v2[v] - constant).norm(), 1e-9) << "vertex " << v;
    EXPECT_NEAR(rho[v], 2.5, 1e-9) << "vertex " << v;
  }
}

TEST_P(LimitOn, LinearFunctionsAreExactAtLimitPositions) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Limit limit(refiner);
  Cochain<0> f(refiner.complex(0));
  const Vec3 slope(1, -2, 0.5);
  for (Index v = 0; v < f.size(); ++v) f[v] = slope.dot(refiner.positions(0)[v]) + 3;
  const auto values = limit.values(refiner.refine(f, BoundaryMode::Walls));
  for (std::size_t v = 0; v < values.size(); ++v) {
    EXPECT_NEAR(values[v], slope.dot(limit.positions()[v]) + 3, 1e-11);
  }
}

TEST_P(LimitOn, NothingCrossesClosedWalls) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Limit limit(refiner);
  const Complex &c = refiner.complex(0), &f = refiner.finest();
  auto form = randomForm<2>(c, 3);
  for (Index k = 0; k < c.facetCount(); ++k) {
    if (c.facetOnBoundary(k)) form[k] = 0;
  }
  const auto vectors =
      limit.vectors(refiner.refine(form, BoundaryMode::Walls), BoundaryMode::Walls);
  // On flat walls exactly; on curved ones as nearly as facets follow the limit surface.
  const bool flat = GetParam().name == "creased box";
  for (const Index facet : refiner.boundary(2).facets) {
    const auto v = f.facetVertices(facet);
    const Vec3 normal = (limit.positions()[v[1]] - limit.positions()[v[0]])
                            .cross(limit.positions()[v[2]] - limit.positions()[v[0]])
                            .normalized();
    for (const Index x : v) {
      const double leak = std::abs(vectors[x].dot(normal));
      if (flat) {
        EXPECT_LT(leak, 1e-12 * (1 + vectors[x].norm()));
      }
    }
  }
  if (flat) {
    for (const Index x : refiner.boundary(2).vertices) EXPECT_TRUE(vectors[x].allFinite());
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, LimitOn, ::testing::ValuesIn(testing::allKinds()), testName);

/// Root mean square difference at points that both fields have, at least `inside` from the border.
double difference(const VectorField& a, const VectorField& b, const std::vector<Vec3>& points) {
  double sum = 0;
  int n = 0;
  for (const Vec3& p : points) {
    Vec3 u, v;
    if (!a.sample(p, &u) || !b.sample(p, &v)) continue;
    sum += (u - v).squaredNorm();
    ++n;
  }
  EXPECT_GT(n, 100);
  return std::sqrt(sum / n);
}

template <int K>
void expectOrders() {
  // A smooth field on a lattice ball; points well inside.
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 16; };
  const ControlMesh mesh = ControlMesh::build(testing::latticeBlock(ball, 4));
  const DeRham rham(*mesh.complex(), mesh.positions(), 8);
  const auto flow = [](const Vec3& p) {
    return Vec3(std::sin(1.3 * p[1]), std::cos(p[2] + 0.5 * p[0]), std::sin(0.5 * p[0] * p[1]));
  };
  Cochain<K> form(*mesh.complex());
  if constexpr (K == 1) {
    form = rham.edges(flow);
  } else {
    form = rham.facets(flow);
  }
  std::vector<Vec3> points;
  for (const Vec3& p : randomPoints(mesh.positions(), 4000)) {
    if (p.norm() < 2) points.push_back(p);
  }
  const auto fieldAt = [&](int levels, Reconstruction reconstruction) {
    RefinerOptions options;
    options.levels = levels;
    const Refiner refiner(mesh, options);
    return makeField<K>(refiner, Limit(refiner), refiner.refine(form, BoundaryMode::Open),
                        BoundaryMode::Open, reconstruction);
  };
  double limit[3], whitney[3];
  for (int level = 0; level < 2; ++level) {
    const auto reference = fieldAt(level + 3, Reconstruction::Limit);
    limit[level] = difference(fieldAt(level, Reconstruction::Limit), reference, points);
    whitney[level] = difference(fieldAt(level, Reconstruction::Whitney), reference, points);
  }
  EXPECT_GT(std::log2(limit[0] / limit[1]), 1.8);
  EXPECT_GT(std::log2(whitney[0] / whitney[1]), 0.8);
  EXPECT_LT(limit[1], whitney[1] / 2);
}

TEST(Limit, IsOfSecondOrderAndWhitneyOfFirst) {
  expectOrders<1>();
  expectOrders<2>();
}

// ---- Rasterising --------------------------------------------------------------------------------

using Samples = std::map<std::array<std::int32_t, 3>, Vec3>;

Samples rasterised(const VectorField& field, const GridFrame& frame, Sampling sampling) {
  Samples samples;
  std::mutex mutex;
  rasterize<3>(field.source(), frame, sampling, [&](const Tile<3>& tile) {
    const std::lock_guard<std::mutex> lock(mutex);
    for (int n = 0; n < Tile<3>::kSize; ++n) {
      const Vec3 value(tile.values[0][n], tile.values[1][n], tile.values[2][n]);
      if (!tile.isActive(n)) {
        EXPECT_EQ(value, Vec3::Zero());
        continue;
      }
      const std::array<std::int32_t, 3> at = {tile.origin[0] + n / 64, tile.origin[1] + n / 8 % 8,
                                              tile.origin[2] + n % 8};
      EXPECT_TRUE(samples.emplace(at, value).second) << "a sample is there twice";
    }
  });
  return samples;
}

VectorField limitField(const ControlMeshInput& input, int levels) {
  const Refiner refiner = refine(input, levels);
  const Limit limit(refiner);
  return makeField<2>(refiner, limit,
                      refiner.refine(randomForm<2>(refiner.complex(0), 5), BoundaryMode::Open),
                      BoundaryMode::Open);
}

void expectSamplesMatch(const VectorField& field, const GridFrame& frame) {
  const Samples samples = rasterised(field, frame, Sampling::Collocated);
  const Vec3 low = (field.bounds().min - frame.origin) / frame.voxelSize;
  const Vec3 high = (field.bounds().max - frame.origin) / frame.voxelSize;
  std::size_t inside = 0;
  for (int i = static_cast<int>(low[0]) - 1; i <= high[0] + 1; ++i) {
    for (int j = static_cast<int>(low[1]) - 1; j <= high[1] + 1; ++j) {
      for (int k = static_cast<int>(low[2]) - 1; k <= high[2] + 1; ++k) {
        Vec3 value;
        const bool found = field.sample(frame.origin + frame.voxelSize * Vec3(i, j, k), &value);
        const auto it = samples.find({i, j, k});
        if (!found && it == samples.end()) continue;
        ASSERT_TRUE(found && it != samples.end()) << i << " " << j << " " << k;
        EXPECT_LT((it->second - value).norm(), 1e-6 * (1 + value.norm()));
        ++inside;
      }
    }
  }
  EXPECT_EQ(inside, samples.size());
  EXPECT_GT(inside, 50u);
}

TEST(Rasterize, EqualsPointSamplingFineAndCoarse) {
  const VectorField field = limitField(testing::creasedBox(2, 0.1, 1), 2);
  // Origins off the mesh' own planes, so that no sample lies on the boundary.
  expectSamplesMatch(field, {Vec3(0.013, 0.021, -0.017), 0.061});
  expectSamplesMatch(field, {Vec3(-0.31, 0.12, 0.055), 0.31});
  const VectorField lattice = limitField(
      testing::latticeBlock([](int x, int y, int z) { return x * x + y * y + z * z <= 9; }, 3), 1);
  expectSamplesMatch(lattice, {Vec3(0.01, 0.02, 0.03), 0.17});
}

TEST(Rasterize, LeavesNoHolesWhereSamplesLieOnFacets) {
  // A unit box whose every facet plane is hit by samples.
  const VectorField field = limitField(testing::creasedBox(2, 0, 1), 1);
  const Samples samples = rasterised(field, {Vec3::Zero(), 0.125}, Sampling::Collocated);
  EXPECT_EQ(samples.size(), 17u * 17 * 17);
}

TEST(Rasterize, StaggeredComponentsLieHalfAVoxelBack) {
  const VectorField field = limitField(testing::creasedBox(2, 0.1, 1), 1);
  const GridFrame frame = {Vec3(0.013, 0.021, -0.017), 0.11};
  const Samples samples = rasterised(field, frame, Sampling::Staggered);
  EXPECT_GT(samples.size(), 1000u);
  for (const auto& [at, value] : samples) {
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 index(at[0], at[1], at[2]);
      index[axis] -= 0.5;
      Vec3 expected;
      if (field.sample(frame.origin + frame.voxelSize * index, &expected)) {
        EXPECT_NEAR(value[axis], expected[axis], 1e-6 * (1 + expected.norm()));
      } else {
        EXPECT_EQ(value[axis], 0);
      }
    }
  }
}

TEST(Rasterize, WhitneyFormsToo) {
  const Refiner refiner = refine(testing::regularOneRing(), 1);
  const Limit limit(refiner);
  const auto field = makeField<1>(
      refiner, limit, refiner.refine(randomForm<1>(refiner.complex(0), 6), BoundaryMode::Open),
      BoundaryMode::Open, Reconstruction::Whitney);
  expectSamplesMatch(field, {Vec3(0.0131, 0.0217, 0.0293), 0.21});
  EXPECT_GT(rasterised(field, {Vec3(0.0131, 0.0217, 0.0293), 0.21}, Sampling::Staggered).size(),
            100u);
}

TEST(Rasterize, DoesNotDependOnThreads) {
  const VectorField field = limitField(testing::randomBall(60, 4), 2);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return rasterised(field, {Vec3::Zero(), 0.04}, Sampling::Collocated);
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(Rasterize, RefusesWhatCannotBe) {
  const VectorField field = limitField(testing::singleTetrahedron(), 1);
  const auto ignore = [](const Tile<3>&) {};
  for (const double size : {0.0, -1.0, std::nan(""), HUGE_VAL, 1e-12}) {
    EXPECT_THROW(rasterize<3>(field.source(), {Vec3::Zero(), size}, Sampling::Collocated, ignore),
                 InputError)
        << size;
  }
  const auto cancel = [](const ProgressReport&) { return false; };
  EXPECT_THROW(
      rasterize<3>(field.source(), {Vec3::Zero(), 0.1}, Sampling::Collocated, ignore, "", cancel),
      Cancelled);
}

}  // namespace
}  // namespace octet
