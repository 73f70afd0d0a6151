// SPDX-License-Identifier: Apache-2.0
// Every long call of the library ends soon when its context says so.
#include <atomic>

#include <gtest/gtest.h>

#include <octet/core/cage/boundary_fit.h>
#include <octet/core/cage/lattice_fill.h>
#include <octet/core/field/field.h>
#include <octet/core/fit/fit.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/hodge/potential.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/primitives/integrate.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/raster/rasterizer.h>
#include <octet/core/streamlines/placement.h>
#include <octet/core/thesis/thesis_subdivision.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

struct LongCall {
  std::string name;
  std::function<void(const Context&)> run;
};

void PrintTo(const LongCall& call, std::ostream* os) { *os << call.name; }

const ControlMesh& cage() {
  static const ControlMesh mesh = ControlMesh::build(testing::creasedBox(4, 0.05, 1));
  return mesh;
}

template <int K>
Cochain<K> form(const Complex& complex) {
  const auto values = testing::randomValues(complex.count(K), 7);
  return Cochain<K>(Array<double>(values.begin(), values.end()));
}

/// A flow through the cage without divergence.
const Cochain<2>& flow() {
  static const Cochain<2> result = d(*cage().complex(), form<1>(*cage().complex()));
  return result;
}

const Refiner& refiner() {
  RefinerOptions options;
  options.levels = 2;
  static const Refiner result(cage(), options);
  return result;
}
const Limit& limit() {
  static const Limit result(refiner());
  return result;
}
const VectorField& field() {
  static const VectorField result = makeField(
      refiner(), limit(), refiner().refine(flow(), BoundaryMode::Open), BoundaryMode::Open);
  return result;
}

const Subdivision& expansion() {
  RefinerOptions options;
  options.levels = 1;
  static const auto result = subdivideByThesis(cage(), ThesisMethod::Expansion, options);
  return *result;
}

PotentialField potentialField() {
  const auto potential = refiner().refine(form<1>(*cage().complex()), BoundaryMode::Open);
  const auto velocity = d(refiner().finest(), potential);
  return PotentialField(refiner().sharedComplex(2), refiner().positions(2), potential,
                        limit().vectors(velocity, BoundaryMode::Open), false);
}

double ball(const Vec3& p) { return p.norm() - 0.9; }
Vec3 toBall(const Vec3& p, Index) { return 0.9 * p.normalized(); }
Box around() {
  Box box;
  box.extend(Vec3(-1, -1, -1));
  box.extend(Vec3(1, 1, 1));
  return box;
}
LatticeFillOptions spacing(double edge) {
  LatticeFillOptions options;
  options.spacing = edge;
  return options;
}

Guides guides() {
  const Box& box = field().bounds();
  GuideCurve curve;
  curve.name = "along";
  for (int k = 0; k <= 8; ++k) {
    curve.points.push_back(box.min + box.size().cwiseProduct(Vec3(0.3 + 0.05 * k, 0.4, 0.5)));
  }
  curve.speeds = {1};
  Guides result;
  result.curves = {curve};
  return result;
}

const auto ignore = [](const Tile<3>&) {};

std::vector<LongCall> longCalls() {
  const auto coefficients = [](auto constant) {
    return form<decltype(constant)::value>(refiner().finest());
  };
  using Zero = std::integral_constant<int, 0>;
  using Three = std::integral_constant<int, 3>;
  RefinerOptions twoLevels;
  twoLevels.levels = 2;
  return {
      {"Refiner", [=](const Context& c) { Refiner(cage(), twoLevels, c); }},
      {"Refiner.refine", [](const Context& c) { refiner().refine(flow(), BoundaryMode::Open, c); }},
      {"Limit", [](const Context& c) { Limit(refiner(), c); }},
      {"Limit.values", [=](const Context& c) { limit().values(coefficients(Zero()), c); }},
      {"Limit.densities", [=](const Context& c) { limit().densities(coefficients(Three()), c); }},
      {"Limit.vectors",
       [](const Context& c) {
         limit().vectors(form<2>(refiner().finest()), BoundaryMode::Open, c);
       }},
      {"sampling",
       [](const Context& c) {
         const std::vector<Vec3> points(20'000, field().bounds().min);
         std::vector<Vec3> values(points.size());
         std::vector<std::uint8_t> inside(points.size());
         field().sample(points.data(), points.size(), values.data(), inside.data(), c);
       }},
      {"rasterize",
       [](const Context& c) {
         const double size = field().bounds().size().maxCoeff() / 80;
         rasterize<3>(field().source(), {Vec3::Zero(), size}, Sampling::Collocated, ignore, "", c);
       }},
      {"rasterizeFluxes",
       [](const Context& c) {
         const double size = field().bounds().size().maxCoeff() / 40;
         rasterizeFluxes(potentialField(), {Vec3::Zero(), size}, ignore, "", c);
       }},
      {"rasterizeMeanFluxes",
       [](const Context& c) {
         const double size = field().bounds().size().maxCoeff() / 40;
         rasterizeMeanFluxes(potentialField(), {Vec3::Zero(), size}, 0.1, ignore, "", c);
       }},
      {"potential",
       [](const Context& c) {
         PotentialSolver(*cage().complex(), cage().positions()).find(flow(), c);
       }},
      {"projection",
       [](const Context& c) {
         nearestClosed(*cage().complex(), cage().positions(), form<2>(*cage().complex()),
                       BoundaryRule::Free, c);
       }},
      {"projection boundary method",
       [=](const Context& c) {
         subdivideByThesis(cage(), ThesisMethod::Projection, twoLevels, c)
             ->refine(flow(), BoundaryMode::Open, c);
       }},
      {"expansion",
       [](const Context& c) { expansion().limitVectors(flow(), BoundaryMode::Open, c); }},
      {"fit", [](const Context& c) { Fit(cage(), {}, c); }},
      {"Fit.solve",
       [](const Context& c) {
         static const Fit fit(cage());
         fit.solve(guides(), c);
       }},
      {"fillLattice",
       [](const Context& c) { fillLattice(around(), ball, spacing(0.2), nullptr, c); }},
      {"fitBoundary",
       [](const Context& c) {
         static const ControlMesh mesh =
             ControlMesh::build(fillLattice(around(), ball, spacing(0.3)));
         fitBoundary(mesh, mesh.positions(), toBall, {}, nullptr, c);
       }},
      {"integrate",
       [](const Context& c) {
         integrate<2>(CurlNoise{}, refiner().finest(), refiner().positions(2), c);
       }},
      {"streamlines",
       [](const Context& c) {
         const VelocityFunction rotation = [](const Vec3& p, Vec3* v) {
           *v = Vec3(-p[1], p[0], 0.1);
           return true;
         };
         PlacementOptions options;
         options.separation = 0.05;
         options.lines.tolerance = 1e-3;
         options.lines.longestStep = 0.01;
         options.lines.longest = 3;
         placeStreamlines(rotation, around(), options, c);
       }},
  };
}

class Stops : public ::testing::TestWithParam<LongCall> {};

/// A context that stops after so many looks at it, from whichever thread.
struct Counter {
  explicit Counter(long mostLooks) : most(mostLooks) {}
  const long most;
  std::atomic<long> looks{0};
  Context context() {
    ContextParts parts;
    parts.stop = [this] { return ++looks > most; };
    return Context(parts);
  }
};

TEST_P(Stops, SoonAfterItIsAsked) {
  constexpr long kNever = 1l << 60;
  Counter whole(kNever);
  GetParam().run(whole.context());
  EXPECT_GE(whole.looks, 5) << "looks up too seldom";
  for (const long part : {0l, whole.looks / 4, whole.looks / 2}) {
    Counter counter(part);
    EXPECT_THROW(GetParam().run(counter.context()), Cancelled);
    EXPECT_LE(counter.looks, part + 200) << "goes on in other threads";
  }
}

INSTANTIATE_TEST_SUITE_P(LongCalls, Stops, ::testing::ValuesIn(longCalls()), [](const auto& call) {
  std::string name = call.param.name;
  for (char& c : name) c = std::isalnum(c) ? c : '_';
  return name;
});

TEST(Memory, OfLevelsIsReservedAndGivenBack) {
  ContextParts parts;
  parts.memoryLimit = 1e6;
  const Context small(parts);
  RefinerOptions options;
  options.levels = 2;
  EXPECT_THROW(Refiner(cage(), options, small), MemoryError);
  EXPECT_NO_THROW(small.reserve(1e6, "everything"));
  parts.memoryLimit = 1e9;
  const Context large(parts);
  {
    const Refiner kept(cage(), options, large);
    EXPECT_THROW(large.reserve(1e9, "everything"), MemoryError);
  }
  EXPECT_NO_THROW(large.reserve(1e9, "everything"));
}

}  // namespace
}  // namespace octet
