// SPDX-License-Identifier: Apache-2.0
// Potentials of closed forms, and grids whose discrete divergence is zero because of them.
#include <map>
#include <mutex>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/hodge/potential.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/raster/flux_rasterizer.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"
#include "tests/support/test_name.h"

namespace octet {
namespace {

using testing::NamedMesh;
using testing::randomForm;
using testing::testName;

template <int K>
double difference(const Cochain<K>& a, const Cochain<K>& b) {
  double largest = 0;
  for (Index k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

/// A random closed 2-form; with closed walls exactly 0 on the boundary.
Cochain<2> randomFlow(const Complex& c, bool closedWalls, std::uint32_t seed) {
  auto potential = randomForm<1>(c, seed);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (closedWalls && c.edgeOnBoundary(e)) potential[e] = 0;
  }
  return d(c, potential);
}

std::vector<NamedMesh> meshes() {
  auto result = testing::allKinds();
  for (NamedMesh& mesh : testing::randomMeshes()) result.push_back(std::move(mesh));
  return result;
}

class PotentialOn : public ::testing::TestWithParam<NamedMesh> {
 protected:
  PotentialOn() : mesh(ControlMesh::build(GetParam().input)), c(*mesh.complex()) {}
  ControlMesh mesh;
  const Complex& c;
};

// ---- Potentials on the control mesh -------------------------------------------------------------

TEST_P(PotentialOn, DerivativeIsTheForm) {
  const PotentialSolver solver(c, mesh.positions());
  for (const bool closedWalls : {false, true}) {
    const auto w = randomFlow(c, closedWalls, 3);
    const auto found = solver.find(w);
    ASSERT_TRUE(found);
    EXPECT_LE(difference(d(c, found->form), w), 1e-13 * (1 + maxNorm(w.values())));
    if (!closedWalls) continue;
    // The form was made from a potential that vanishes there, so one exists.
    EXPECT_TRUE(found->zeroOnBoundary);
    for (Index e = 0; e < c.edgeCount(); ++e) {
      if (c.edgeOnBoundary(e)) {
        ASSERT_EQ(found->form[e], 0);
      }
    }
  }
}

TEST_P(PotentialOn, RefiningItRefinesTheForm) {
  const PotentialSolver solver(c, mesh.positions());
  RefinerOptions options;
  options.levels = 2;
  const Refiner refiner(mesh, options);
  for (const bool closedWalls : {false, true}) {
    const auto w = randomFlow(c, closedWalls, 4);
    const BoundaryMode mode = automaticMode(c, w);
    const auto fine = refiner.refine(solver.find(w)->form, mode);
    const auto expected = refiner.refine(w, mode);
    EXPECT_LE(difference(d(refiner.finest(), fine), expected), 1e-12 * maxNorm(w.values()));
    for (Index e = 0; closedWalls && e < fine.size(); ++e) {
      if (refiner.finest().edgeOnBoundary(e)) {
        ASSERT_EQ(fine[e], 0);
      }
    }
  }
}

TEST_P(PotentialOn, ScalarPotentialsOfGradients) {
  const auto f = randomForm<0>(c, 5);
  const auto w = d(c, f);
  const auto found = scalarPotential(c, w);
  ASSERT_TRUE(found);
  EXPECT_LE(difference(d(c, *found), w), 1e-13);
}

TEST_P(PotentialOn, FormsThatAreNotClosedHaveNone) {
  auto w = randomFlow(c, false, 6);
  const Index cell = c.cellCount() / 2;
  // Through a facet of that cell, on the boundary if it has one there: then no other cell opens.
  w[c.cellFacet(cell, 0).index()] += 0.01;
  EXPECT_FALSE(PotentialSolver(c, mesh.positions()).find(w));
  const Openness open = openness(c, w);
  EXPECT_NEAR(open.largest, 0.01, 1e-13);
  bool beside = false;
  for (int k = 0; k < c.cellFacetCount(open.at); ++k) {
    beside = beside || c.cellFacet(open.at, k).index() == c.cellFacet(cell, 0).index();
  }
  EXPECT_TRUE(beside);
  auto gradient = d(c, randomForm<0>(c, 7));
  gradient[0] += 0.01;
  EXPECT_FALSE(scalarPotential(c, gradient));
}

/// A thick shell around a void.
ControlMesh shell() {
  return ControlMesh::build(testing::latticeBlock(
      [](int x, int y, int z) {
        const int r2 = x * x + y * y + z * z;
        return r2 >= 2 && r2 <= 16;
      },
      4));
}

/// A ring around the z axis.
ControlMesh ring() {
  return ControlMesh::build(testing::latticeBlock(
      [](int x, int y, int z) {
        const int r = std::max(std::abs(x), std::abs(y));
        return r >= 2 && r <= 5 && std::abs(z) <= 2;
      },
      5));
}

TEST(Potential, FluxIntoAVoidHasNone) {
  const ControlMesh mesh = shell();
  const Complex& c = *mesh.complex();
  const DeRham rham(c, mesh.positions(), 10);
  const auto source = [](const Vec3& p) { return Vec3(p / std::pow(p.norm(), 3)); };
  const auto w = nearestClosed(c, mesh.positions(), rham.facets(source));
  ASSERT_LT(openness(c, w).relative, 1e-12);
  EXPECT_FALSE(PotentialSolver(c, mesh.positions()).find(w));
  const auto pieces = boundaryFluxes(c, w);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_NEAR(pieces[0].flux, -pieces[1].flux, 1e-12);
  EXPECT_NEAR(std::abs(pieces[0].flux), 4 * 3.14159265358979, 0.2);
  // Without that flux there is one.
  EXPECT_TRUE(PotentialSolver(c, mesh.positions()).find(randomFlow(c, true, 8)));
}

TEST(Potential, FlowAroundAHandleHasOneThatDoesNotVanishOnTheWalls) {
  const ControlMesh mesh = ring();
  const Complex& c = *mesh.complex();
  const DeRham rham(c, mesh.positions(), 10);
  const auto turn = [](const Vec3& p) {
    return Vec3(Vec3(-p[1], p[0], 0) / (p[0] * p[0] + p[1] * p[1]));
  };
  const auto w = nearestClosed(c, mesh.positions(), rham.facets(turn), BoundaryRule::Zero);
  const auto found = PotentialSolver(c, mesh.positions()).find(w);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->zeroOnBoundary);
  EXPECT_LE(difference(d(c, found->form), w), 1e-12);
  // The same field as a 1-form is closed up to quadrature and has no potential.
  const auto circulation = nearestClosed(c, mesh.positions(), rham.edges(turn));
  ASSERT_LT(openness(c, circulation).relative, 1e-12);
  EXPECT_FALSE(scalarPotential(c, circulation));
}

// ---- Grids --------------------------------------------------------------------------------------

/// A refined flow with its potential, ready to be sampled.
struct Flow {
  Flow(const ControlMesh& mesh, const Cochain<2>& w, int levels)
      : refiner(mesh, optionsFor(levels)), limit(refiner), mode(automaticMode(*mesh.complex(), w)) {
    const PotentialSolver solver(*mesh.complex(), mesh.positions());
    potential = refiner.refine(solver.find(w)->form, mode);
    fine = refiner.refine(w, mode);
  }
  PotentialField field() const {
    const int level = refiner.levels();
    return PotentialField(refiner.sharedComplex(level), refiner.positions(level), potential,
                          limit.vectors(fine, mode), mode == BoundaryMode::Walls);
  }
  VectorField sampled() const { return makeField<2>(refiner, limit, fine, mode); }
  double meanEdge() const {
    double sum = 0;
    const auto& x = refiner.positions(refiner.levels());
    for (const auto& [a, b] : refiner.finest().edges) sum += (x[b] - x[a]).norm();
    return sum / refiner.finest().edgeCount();
  }
  static RefinerOptions optionsFor(int levels) {
    RefinerOptions options;
    options.levels = levels;
    return options;
  }

  Refiner refiner;
  Limit limit;
  BoundaryMode mode;
  Cochain<1> potential;
  Cochain<2> fine;
};

using Ijk = std::array<int, 3>;
struct Voxel {
  Vec3 value;
  bool active;
};
class Voxels {
 public:
  Voxels(const PotentialField& field, const GridFrame& frame, Sampling sampling,
         double neighbours = 0.1) {
    std::mutex mutex;
    const auto sink = [&](const Tile<3>& tile) {
      const std::lock_guard<std::mutex> lock(mutex);
      for (int n = 0; n < Tile<3>::kSize; ++n) {
        const Ijk at = {tile.origin[0] + n / 64, tile.origin[1] + n / 8 % 8,
                        tile.origin[2] + n % 8};
        map[at] = {Vec3(tile.values[0][n], tile.values[1][n], tile.values[2][n]), tile.isActive(n)};
      }
    };
    if (sampling == Sampling::Staggered) {
      rasterizeFluxes(field, frame, sink);
    } else {
      rasterizeMeanFluxes(field, frame, neighbours, sink);
    }
  }
  Vec3 at(Ijk ijk, int axis = 0, int by = 0) const {
    ijk[axis] += by;
    const auto it = map.find(ijk);
    return it == map.end() ? Vec3(Vec3::Zero()) : it->second.value;
  }
  bool active(Ijk ijk, int axis, int by) const {
    ijk[axis] += by;
    const auto it = map.find(ijk);
    return it != map.end() && it->second.active;
  }
  double largest() const {
    double result = 0;
    for (const auto& [ijk, voxel] : map) result = std::max(result, voxel.value.norm());
    return result;
  }

  std::map<Ijk, Voxel> map;
};

constexpr double kRatios[] = {0.4, 1.0, 2.2};  // voxels per mean fine edge

/// Of double values, where only the sums' own rounding is left.
constexpr double kRounding = 2e-11;

TEST_P(PotentialOn, StaggeredDivergenceIsZero) {
  for (const bool closedWalls : {false, true}) {
    const Flow flow(mesh, randomFlow(c, closedWalls, 9), 1);
    const PotentialField field = flow.field();
    EXPECT_EQ(field.zeroOnBoundary(), closedWalls);
    for (const double ratio : kRatios) {
      const GridFrame frame = {Vec3(0.013, 0.021, 0.017), ratio * flow.meanEdge()};
      const Voxels voxels(field, frame, Sampling::Staggered);
      const double scale = voxels.largest();
      for (const auto& [ijk, voxel] : voxels.map) {
        // With closed walls all of space is free of divergence, outside and cut voxels too.
        if (!voxel.active && !closedWalls) continue;
        double outflow = 0;
        for (int k = 0; k < 3; ++k) outflow += voxels.at(ijk, k, 1)[k] - voxel.value[k];
        ASSERT_LE(std::abs(outflow), kRounding * scale);
      }
    }
  }
}

TEST_P(PotentialOn, CollocatedCentralDivergenceIsZero) {
  const Flow flow(mesh, randomFlow(c, true, 10), 1);
  for (const double ratio : {0.3, 0.6}) {
    const GridFrame frame = {Vec3(0.013, 0.021, 0.017), ratio * flow.meanEdge()};
    const Voxels voxels(flow.field(), frame, Sampling::Collocated, neighbourWeight(ratio));
    const double scale = voxels.largest();
    for (const auto& [ijk, voxel] : voxels.map) {
      double outflow = 0;
      bool inside = true;
      for (int k = 0; k < 3; ++k) {
        inside = inside && voxels.active(ijk, k, 1) && voxels.active(ijk, k, -1);
        outflow += (voxels.at(ijk, k, 1)[k] - voxels.at(ijk, k, -1)[k]) / 2;
      }
      if (inside) {
        ASSERT_LE(std::abs(outflow), kRounding * scale);
      }
    }
  }
}

TEST_P(PotentialOn, ConstantFlowsAreExact) {
  // Open boundaries keep constants everywhere (SCHEME.md section 8).
  const Vec3 constant(0.3, -1.2, 0.7);
  const DeRham rham(c, mesh.positions(), 1);
  const Flow flow(mesh, rham.facets([&](const Vec3&) { return constant; }), 1);
  const GridFrame frame = {Vec3(0.013, 0.021, 0.017), 0.15 * flow.meanEdge()};
  for (const Sampling sampling : {Sampling::Staggered, Sampling::Collocated}) {
    const Voxels voxels(flow.field(), frame, sampling);
    int active = 0;
    for (const auto& [ijk, voxel] : voxels.map) {
      if (!voxel.active) continue;
      ++active;
      ASSERT_LT((voxel.value - constant).norm(), 1e-8);
    }
    EXPECT_GT(active, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, PotentialOn, ::testing::ValuesIn(meshes()), testName);

TEST(FluxRasterizer, EveryWallAlignedFaceIsTight) {
  // Voxel faces lie in the walls and in facets between cells.
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(2, 0, 1));
  const Flow flow(mesh, randomFlow(*mesh.complex(), true, 11), 2);
  const Voxels voxels(flow.field(), {Vec3::Constant(0.0625), 0.125}, Sampling::Staggered);
  const double scale = voxels.largest();
  int inside = 0;
  for (const auto& [ijk, voxel] : voxels.map) {
    for (int k = 0; k < 3; ++k) {
      const bool through = ijk[k] > 0 && ijk[k] < 16;  // face k is at ijk/8
      bool beside = true;
      for (int j = 0; j < 3; ++j) beside = beside && (j == k || (ijk[j] >= 0 && ijk[j] < 16));
      if (through && beside) {
        ++inside;
      } else {
        ASSERT_LE(std::abs(voxel.value[k]), 1e-5 * scale)
            << ijk[0] << " " << ijk[1] << " " << ijk[2];
      }
    }
  }
  EXPECT_EQ(inside, 3 * 15 * 16 * 16);
}

TEST(FluxRasterizer, DoesNotDependOnThreads) {
  const ControlMesh mesh = ControlMesh::build(testing::withOctahedra(testing::randomBall(60, 5)));
  const Flow flow(mesh, randomFlow(*mesh.complex(), true, 12), 1);
  const auto run = [&](Sampling sampling, std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    std::map<Ijk, std::array<double, 3>> values;
    for (const auto& [ijk, voxel] : Voxels(flow.field(), {Vec3::Zero(), 0.05}, sampling).map) {
      values[ijk] = {voxel.value[0], voxel.value[1], voxel.value[2]};
    }
    return values;
  };
  for (const Sampling sampling : {Sampling::Staggered, Sampling::Collocated}) {
    EXPECT_EQ(run(sampling, 1), run(sampling, 2));
  }
}

TEST(FluxRasterizer, RefusesWhatCannotBe) {
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(2, 0, 1));
  const Flow flow(mesh, randomFlow(*mesh.complex(), true, 13), 1);
  const auto ignore = [](const Tile<3>&) {};
  for (const double size : {0.0, -1.0, std::nan(""), HUGE_VAL, 1e-12}) {
    EXPECT_THROW(rasterizeFluxes(flow.field(), {Vec3::Zero(), size}, ignore), InputError) << size;
  }
  const auto cancel = [](const ProgressReport&) { return false; };
  EXPECT_THROW(rasterizeFluxes(flow.field(), {Vec3::Zero(), 0.1}, ignore, "", cancel), Cancelled);
}

/// Root mean square errors against a deep reference, well inside the domain.
struct Errors {
  double flux = 0, sampled = 0;
};

Errors errorsAt(const ControlMesh& mesh, const Cochain<2>& w, int levels, double ratio,
                const VectorField& reference) {
  const Flow flow(mesh, w, levels);
  const VectorField sampled = flow.sampled();
  const GridFrame frame = {Vec3(0.013, 0.021, 0.017), ratio * flow.meanEdge()};
  const Voxels voxels(flow.field(), frame, Sampling::Staggered);
  const Vec3 middle = (reference.bounds().min + reference.bounds().max) / 2;
  const Vec3 reach = 0.3 * reference.bounds().size();
  Errors sum;
  int n = 0;
  for (const auto& [ijk, voxel] : voxels.map) {
    for (int k = 0; k < 3; ++k) {
      Vec3 index(ijk[0], ijk[1], ijk[2]);
      index[k] -= 0.5;
      const Vec3 p = frame.origin + frame.voxelSize * index;
      Vec3 truth, sample;
      if (((p - middle).cwiseAbs() - reach).maxCoeff() > 0) continue;
      if (!reference.sample(p, &truth) || !sampled.sample(p, &sample)) continue;
      sum.flux += std::pow(voxel.value[k] - truth[k], 2);
      sum.sampled += std::pow(sample[k] - truth[k], 2);
      ++n;
    }
  }
  EXPECT_GT(n, 50);
  return {std::sqrt(sum.flux / n), std::sqrt(sum.sampled / n)};
}

TEST(FluxRasterizer, VelocityErrorFallsWithOrderTwo) {
  const auto block = [](int x, int y, int z) {
    return std::max({std::abs(x), std::abs(y), std::abs(z)}) <= 3;
  };
  const ControlMesh mesh = ControlMesh::build(testing::latticeBlock(block, 3));
  const Complex& c = *mesh.complex();
  const DeRham rham(c, mesh.positions(), 8);
  const auto w = d(c, rham.edges([](const Vec3& p) {
    return Vec3(std::sin(0.5 * p[1]) * std::sin(p[2]), std::sin(0.6 * p[0]) * std::cos(0.5 * p[2]),
                std::sin(0.5 * p[0]) * std::cos(0.7 * p[1]));
  }));
  const Flow deep(mesh, w, 4);
  const VectorField reference = deep.sampled();
  for (const double ratio : {0.5, 1.0}) {
    const Errors coarse = errorsAt(mesh, w, 1, ratio, reference);
    const Errors fine = errorsAt(mesh, w, 2, ratio, reference);
    const double order = std::log2(coarse.flux / fine.flux);
    std::printf("voxel / edge %.1f: error %.3g, then %.3g: order %.2f (sampled %.3g, %.3g)\n",
                ratio, coarse.flux, fine.flux, order, coarse.sampled, fine.sampled);
    EXPECT_GT(order, 1.75);
  }
}

TEST(FluxRasterizer, IsAsAccurateAsSamplingOnIrregularMeshes) {
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(2, 0.1, 1));
  const Complex& c = *mesh.complex();
  const auto w = randomFlow(c, true, 14);
  const Flow deep(mesh, w, 4);
  const VectorField reference = deep.sampled();
  for (const double ratio : {0.7, 1.4}) {
    const Errors errors = errorsAt(mesh, w, 2, ratio, reference);
    EXPECT_LT(errors.flux, 1.15 * errors.sampled) << ratio;
  }
}

}  // namespace
}  // namespace octet
