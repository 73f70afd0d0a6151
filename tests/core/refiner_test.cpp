// SPDX-License-Identifier: Apache-2.0
// Properties that hold on any mesh, to rounding: commutation with d, constants, walls.
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/hodge/potential.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/forms.h"
#include "tests/support/meshes.h"
#include "tests/support/test_name.h"

namespace octet {
namespace {

using testing::allKinds;
using testing::NamedMesh;
using testing::randomForm;
using testing::randomMeshes;
using testing::randomValues;
using testing::testName;

constexpr double kExact = 1e-12;

double largestDifference(const Array<double>& a, const Array<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double result = 0;
  for (std::size_t k = 0; k < a.size(); ++k) result = std::max(result, std::abs(a[k] - b[k]));
  return result;
}

Refiner refine(const ControlMeshInput& input, int levels, double zeta = kDefaultZeta) {
  RefinerOptions options;
  options.levels = levels;
  options.zeta = zeta;
  return Refiner(ControlMesh::build(input), options);
}

std::vector<NamedMesh> meshes() {
  auto all = allKinds();
  for (NamedMesh& mesh : randomMeshes()) all.push_back(std::move(mesh));
  return all;
}

Vec3 edgeVector(const Complex& c, const Array<Vec3>& x, Index e) {
  return x[c.edges[e][1]] - x[c.edges[e][0]];
}

Vec3 areaVector(const Complex& c, const Array<Vec3>& x, Index f) {
  const auto v = c.facetVertices(f);
  return (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 2;
}

class AnyMesh : public ::testing::TestWithParam<NamedMesh> {
 protected:
  static constexpr BoundaryMode kModes[] = {BoundaryMode::Walls, BoundaryMode::Open};
};

TEST_P(AnyMesh, CoboundaryTwiceIsZero) {
  const Refiner refiner = refine(GetParam().input, 2);
  for (int level = 0; level <= 2; ++level) {
    const Complex& c = refiner.complex(level);
    EXPECT_LE(maxNorm(d(c, d(c, randomForm<0>(c, 1))).values()), kExact);
    EXPECT_LE(maxNorm(d(c, d(c, randomForm<1>(c, 2))).values()), kExact);
  }
}

TEST_P(AnyMesh, SubdivisionCommutesWithD) {
  for (const double zeta : {kDefaultZeta, -6.3}) {
    const Refiner refiner = refine(GetParam().input, 2, zeta);
    for (int level = 0; level < 2; ++level) {
      const Complex &c = refiner.complex(level), &f = refiner.complex(level + 1);
      for (const BoundaryMode mode : kModes) {
        const auto f0 = randomForm<0>(c, 3);
        const auto f1 = randomForm<1>(c, 4);
        const auto f2 = randomForm<2>(c, 5);
        EXPECT_LE(largestDifference(d(f, refiner.step(level, f0, mode)).values(),
                                    refiner.step(level, d(c, f0), mode).values()),
                  kExact);
        // Where cells are flat the patch test's weights are large, and rounding with them.
        const auto curl = d(f, refiner.step(level, f1, mode));
        EXPECT_LE(largestDifference(curl.values(), refiner.step(level, d(c, f1), mode).values()),
                  kExact * std::max(1.0, maxNorm(curl.values())));
        const auto flux = refiner.step(level, f2, mode);
        EXPECT_LE(
            largestDifference(d(f, flux).values(), refiner.step(level, d(c, f2), mode).values()),
            kExact * std::max(1.0, maxNorm(flux.values())));
      }
    }
  }
}

TEST_P(AnyMesh, ConstantGradientsAreExactInEveryMode) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Complex &c = refiner.complex(0), &f = refiner.finest();
  for (int axis = 0; axis < 3; ++axis) {
    Cochain<1> form(c), expected(f);
    for (Index e = 0; e < form.size(); ++e) form[e] = edgeVector(c, refiner.positions(0), e)[axis];
    for (Index e = 0; e < expected.size(); ++e) {
      expected[e] = edgeVector(f, refiner.positions(2), e)[axis];
    }
    for (const BoundaryMode mode : kModes) {
      EXPECT_LE(largestDifference(refiner.refine(form, mode).values(), expected.values()), kExact);
    }
  }
}

TEST_P(AnyMesh, ConstantFluxesAreExact) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Complex &c = refiner.complex(0), &f = refiner.finest();
  for (int axis = 0; axis < 3; ++axis) {
    Cochain<2> form(c), expected(f);
    for (Index k = 0; k < form.size(); ++k) form[k] = areaVector(c, refiner.positions(0), k)[axis];
    for (Index k = 0; k < expected.size(); ++k) {
      expected[k] = areaVector(f, refiner.positions(2), k)[axis];
    }
    EXPECT_LE(
        largestDifference(refiner.refine(form, BoundaryMode::Open).values(), expected.values()),
        kExact);
    // In walls mode, off the wall at every level: facets of children of inner cells.
    const auto walls = refiner.refine(form, BoundaryMode::Walls);
    for (Index k = 0; k < f.facetCount(); ++k) {
      bool touches = false;
      const Complex* level = &f;
      for (Index facet = k; level; level = level->coarse.get()) {
        for (const Index v : level->facetVertices(facet)) touches |= level->vertexOnBoundary(v);
        if (!level->coarse || facet >= 4 * level->coarse->facetCount()) break;
        facet /= 4;
      }
      if (!touches && k < 16 * c.facetCount()) {
        EXPECT_NEAR(walls[k], expected[k], kExact) << "facet " << k;
      }
    }
  }
}

TEST(FlatWalls, KeepConstantFluxesEverywhere) {
  for (const double jitter : {0.0, 0.2}) {
    const Refiner refiner = refine(testing::creasedBox(3, jitter, 5), 2);
    const Complex &c = refiner.complex(0), &f = refiner.finest();
    for (int axis = 0; axis < 3; ++axis) {
      Cochain<2> form(c);
      for (Index k = 0; k < form.size(); ++k) {
        form[k] = areaVector(c, refiner.positions(0), k)[axis];
      }
      const auto walls = refiner.refine(form, BoundaryMode::Walls);
      for (Index k = 0; k < walls.size(); ++k) {
        ASSERT_NEAR(walls[k], areaVector(f, refiner.positions(2), k)[axis], kExact);
      }
    }
  }
}

TEST_P(AnyMesh, ZeroWallFluxStaysZeroInWalls) {
  const Refiner refiner = refine(GetParam().input, 2);
  const Complex& c = refiner.complex(0);
  auto form = randomForm<2>(c, 6);
  auto circulation = randomForm<1>(c, 7);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) form[f] = 0;
  }
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (c.edgeOnBoundary(e)) circulation[e] = 0;
  }
  ASSERT_EQ(automaticMode(c, form), BoundaryMode::Walls);
  ASSERT_EQ(automaticMode(c, circulation), BoundaryMode::Walls);
  const auto fine = refiner.refine(form, BoundaryMode::Walls);
  const auto fineCirculation = refiner.refine(circulation, BoundaryMode::Walls);
  for (const Index f : refiner.boundary(2).facets) EXPECT_EQ(fine[f], 0.0);
  for (const Index e : refiner.boundary(2).edges) EXPECT_EQ(fineCirculation[e], 0.0);
}

TEST_P(AnyMesh, TotalMassIsKept) {
  const Refiner refiner = refine(GetParam().input, 2);
  const auto form = randomForm<3>(refiner.complex(0), 8);
  const auto fine = refiner.refine(form, BoundaryMode::Walls);
  double before = 0, after = 0;
  for (const double x : form.values()) before += x;
  for (const double x : fine.values()) after += x;
  EXPECT_NEAR(before, after, kExact * form.size());
}

TEST_P(AnyMesh, ConstantFunctionsAreKept) {
  const Refiner refiner = refine(GetParam().input, 2);
  Cochain<0> one(refiner.complex(0));
  for (Index v = 0; v < one.size(); ++v) one[v] = 1;
  const auto fine = refiner.refine(one, BoundaryMode::Walls);
  for (Index v = 0; v < fine.size(); ++v) EXPECT_NEAR(fine[v], 1, kExact);
}

/// All numbers that a refiner makes, in a row.
class Numbers {
 public:
  template <int K>
  void addForm(const Refiner& refiner, const Limit& limit, std::uint32_t seed) {
    for (const BoundaryMode mode : {BoundaryMode::Walls, BoundaryMode::Open}) {
      const auto fine = refiner.refine(randomForm<K>(refiner.complex(0), seed), mode);
      all_.insert(all_.end(), fine.values().begin(), fine.values().end());
      if constexpr (K == 0) {
        const auto values = limit.values(fine);
        all_.insert(all_.end(), values.begin(), values.end());
      } else if constexpr (K == 3) {
        const auto values = limit.densities(fine);
        all_.insert(all_.end(), values.begin(), values.end());
      } else {
        addPoints(limit.vectors(fine, mode));
      }
    }
  }
  void addPoints(const Array<Vec3>& points) {
    for (const Vec3& p : points) all_.insert(all_.end(), p.begin(), p.end());
  }
  bool operator==(const Numbers& other) const {
    return all_.size() == other.all_.size() &&
           std::memcmp(all_.data(), other.all_.data(), all_.size() * sizeof(double)) == 0;
  }

 private:
  std::vector<double> all_;
};

TEST_P(AnyMesh, BytesDoNotDependOnThreads) {
  const auto run = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Refiner refiner = refine(GetParam().input, 2);
    const Limit limit(refiner);
    Numbers numbers;
    numbers.addPoints(refiner.positions(2));
    numbers.addPoints(limit.positions());
    numbers.addForm<0>(refiner, limit, 9);
    numbers.addForm<1>(refiner, limit, 10);
    numbers.addForm<2>(refiner, limit, 11);
    numbers.addForm<3>(refiner, limit, 12);
    return numbers;
  };
  EXPECT_TRUE(run(1) == run(2));
}

/// A mesh of its own with the cells of a level, numbered alike.
ControlMesh copyOf(const Refiner& refiner, int level) {
  const Complex& c = refiner.complex(level);
  ControlMeshInput input;
  input.vertices = refiner.positions(level);
  input.tets = c.tets;
  input.octs = c.octs;
  return ControlMesh::build(input);
}

TEST(Cochains, OfAnotherMeshOrLevelOfEqualSizeAreRefused) {
  RefinerOptions options;
  options.levels = 1;
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(1, 0.1, 1));
  const Refiner refiner(mesh, options);
  for (const int level : {0, 1}) {
    SCOPED_TRACE(level);
    const ControlMesh other = copyOf(refiner, level);
    const Complex& c = *other.complex();
    const Refiner stranger(other, options);
    const Cochain<1> w(refiner.complex(level));
    const Cochain<2> flux(refiner.complex(level));
    ASSERT_EQ(w.size(), c.edgeCount());
    ASSERT_EQ(flux.size(), c.facetCount());
    EXPECT_THROW(d(c, w), InputError);
    EXPECT_THROW(automaticMode(c, w), InputError);
    EXPECT_THROW(stranger.step(0, flux, BoundaryMode::Open), InputError);
    EXPECT_THROW(stranger.refine(w, BoundaryMode::Open), InputError);
    EXPECT_THROW(nearestClosed(c, other.positions(), flux), InputError);
    EXPECT_THROW(scalarPotential(c, w), InputError);
    EXPECT_THROW(PotentialSolver(c, other.positions()).find(flux), InputError);
    EXPECT_THROW(boundaryFluxes(c, flux), InputError);
    EXPECT_THROW((Cochain<1>(c, Array<double>(3, 0.0))), InputError);
    RefinerOptions unrefined;
    unrefined.levels = 0;
    const Refiner same(other, unrefined);
    const Limit limit(same);
    EXPECT_THROW(limit.vectors(w, BoundaryMode::Open), InputError);
    EXPECT_THROW(limit.values(Cochain<0>(refiner.complex(level))), InputError);
    EXPECT_THROW(limit.densities(Cochain<3>(refiner.complex(level))), InputError);
    EXPECT_THROW(makeField(same, limit, flux, BoundaryMode::Open, Reconstruction::Whitney),
                 InputError);
    EXPECT_NO_THROW(limit.vectors(Cochain<1>(c), BoundaryMode::Open));
  }
}

TEST(Cochains, GoFromOneRefinerOfAMeshToAnother) {
  RefinerOptions options;
  options.levels = 1;
  const ControlMesh mesh = ControlMesh::build(testing::creasedBox(1, 0.1, 1));
  const Refiner one(mesh, options), other(mesh, options);
  const auto fine = one.refine(Cochain<2>(*mesh.complex()), BoundaryMode::Open);
  EXPECT_NO_THROW(d(other.finest(), fine));
  EXPECT_THROW(d(other.complex(0), fine), InputError);
}

TEST_P(AnyMesh, OneRefinerServesManyFormsAsIfEachHadItsOwn) {
  const Refiner shared = refine(GetParam().input, 2);
  for (const std::uint32_t frame : {20u, 21u, 20u}) {
    const Refiner own = refine(GetParam().input, 2);
    const Limit sharedLimit(shared), ownLimit(own);
    Numbers together, alone;
    together.addForm<1>(shared, sharedLimit, frame);
    together.addForm<2>(shared, sharedLimit, frame);
    alone.addForm<1>(own, ownLimit, frame);
    alone.addForm<2>(own, ownLimit, frame);
    EXPECT_TRUE(together == alone);
  }
}

TEST_P(AnyMesh, FarFromTheOriginNothingChanges) {
  ControlMeshInput moved = GetParam().input;
  for (Vec3& p : moved.vertices) p += Vec3(4096, -2048, 1024);
  const Refiner here = refine(GetParam().input, 1), there = refine(moved, 1);
  const auto form = randomForm<2>(here.complex(0), 10);
  const auto a = here.refine(form, BoundaryMode::Open).values();
  const auto b = there.refine(form, BoundaryMode::Open).values();
  EXPECT_LE(largestDifference(a, b), 1e-9 * std::max(1.0, maxNorm(a)));
}

INSTANTIATE_TEST_SUITE_P(Meshes, AnyMesh, ::testing::ValuesIn(meshes()), testName);

}  // namespace
}  // namespace octet
