// SPDX-License-Identifier: Apache-2.0
// Fields fitted to guides: what they follow, and what holds exactly.
#include <Eigen/Cholesky>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/core/field/field.h>
#include <octet/core/fit/fit.h>
#include <octet/core/fit/least_squares.h>
#include <octet/core/fit/smoothness.h>
#include <octet/core/fit/wall_potential.h>
#include <octet/core/forms/coboundary.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

constexpr double kPi = 3.14159265358979323846;

using Function = std::function<Vec3(const Vec3&)>;

/// A curve along a field from `start`, with the field's speed.
GuideCurve streamline(const std::string& name, const Function& field, Vec3 start, double step,
                      int steps) {
  GuideCurve curve;
  curve.name = name;
  for (int k = 0; k <= steps; ++k) {
    const Vec3 v = field(start);
    curve.points.push_back(start);
    curve.speeds.push_back(v.norm());
    const Vec3 half = start + step / 2 * v.normalized();
    start += step * field(half).normalized();
  }
  return curve;
}

GuideCurve line(const std::string& name, const Vec3& from, const Vec3& to, double speed) {
  GuideCurve curve;
  curve.name = name;
  for (int k = 0; k <= 8; ++k) curve.points.push_back(from + k / 8.0 * (to - from));
  curve.speeds = {speed};
  return curve;
}

GuideCurve circle(const std::string& name, const Vec3& centre, double radius, double speed) {
  GuideCurve curve;
  curve.name = name;
  for (int k = 0; k <= 48; ++k) {
    const double t = 2 * kPi * (k % 48) / 48;
    curve.points.push_back(centre + radius * Vec3(std::cos(t), std::sin(t), 0));
  }
  curve.speeds = {speed};
  return curve;
}

/// A creased box, 1 wide.
ControlMeshInput unitBox(int n, double jitter, std::uint32_t seed) {
  ControlMeshInput box = testing::creasedBox(n, jitter, seed);
  for (Vec3& p : box.vertices) p /= n;
  return box;
}

ControlMesh mesh(const ControlMeshInput& input) { return ControlMesh::build(input); }

/// Largest coefficient on the boundary.
double onBoundary(const Complex& c, const Cochain<2>& form) {
  double largest = 0;
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f)) largest = std::max(largest, std::abs(form[f]));
  }
  return largest;
}

/// Largest |divergence| of a refined 2-form, relative to its largest flux.
double divergence(const Refiner& refiner, const Cochain<2>& form, BoundaryMode mode) {
  const Cochain<2> fine = refiner.refine(form, mode);
  return maxNorm(d(refiner.finest(), fine).values()) / maxNorm(fine.values());
}

Refiner refine(const ControlMesh& m, int levels) {
  RefinerOptions options;
  options.levels = levels;
  return Refiner(m, options);
}

/// Two counter-rotating rolls in the unit box, tangential to its walls.
Vec3 rolls(const Vec3& p) {
  return {std::sin(kPi * p[0]) * std::cos(2 * kPi * p[1]) * 2,
          -std::cos(kPi * p[0]) * std::sin(2 * kPi * p[1]), 0};
}

Guides sixRolls() {
  Guides guides;
  int k = 0;
  for (const double y : {0.15, 0.85}) {
    for (const double z : {0.2, 0.5, 0.8}) {
      guides.curves.push_back(
          streamline("roll " + std::to_string(++k), rolls, Vec3(0.5, y, z), 0.02, 45));
    }
  }
  return guides;
}

TEST(Fit, FollowsSixCurvesInCreasedBox) {
  const ControlMesh box = mesh(unitBox(6, 0.1, 5));
  const FitResult result = Fit(box).solve(sixRolls());
  ASSERT_EQ(result.report.guides.size(), 6u);
  for (const GuideReport& guide : result.report.guides) {
    EXPECT_LT(guide.residual, 0.05) << guide.name;
  }
  EXPECT_TRUE(result.report.conflicts.empty());
  // Closed walls: exactly 0 on the control mesh and after refinement. No divergence, to rounding.
  EXPECT_EQ(onBoundary(*box.complex(), *result.flux), 0.0);
  EXPECT_LT(result.report.wallFlux, 1e-12);
  const Refiner refiner = refine(box, 2);
  EXPECT_EQ(onBoundary(refiner.finest(), refiner.refine(*result.flux, result.mode)), 0.0);
  EXPECT_LT(divergence(refiner, *result.flux, result.mode), 1e-12);
  // The field is d of the potential that is reported with it.
  const Cochain<2> again = d(*box.complex(), *result.vectorPotential);
  for (Index f = 0; f < again.size(); ++f) {
    EXPECT_NEAR(again[f], (*result.flux)[f], 1e-13 * maxNorm(again.values()));
  }
}

/// Speed does not grow from guides to walls, nor to an open boundary, where nothing else holds it.
TEST(Fit, KeepsSpeedOfItsGuides) {
  const ControlMesh box = mesh(unitBox(6, 0.1, 5));
  Guides guides;
  guides.curves = {circle("low", Vec3(0.5, 0.5, 0.3), 0.3, 1),
                   circle("high", Vec3(0.5, 0.5, 0.7), 0.3, -1)};
  const Refiner refiner = refine(box, 2);
  const Limit limit(refiner);
  for (const bool closed : {true, false}) {
    FitOptions options;
    options.closedWalls = closed;
    const FitResult result = Fit(box, options).solve(guides);
    EXPECT_LT(result.report.residual, 0.01);
    const VectorField field =
        makeField(refiner, limit, refiner.refine(*result.flux, result.mode), result.mode);
    double fastest = 0;
    for (const Vec3& p : limit.positions()) {
      Vec3 v = Vec3::Zero();
      field.sample(p, &v);
      fastest = std::max(fastest, v.norm());
    }
    EXPECT_LT(fastest, 1.25) << (closed ? "closed" : "open");
    EXPECT_GT(fastest, 0.95);
  }
}

/// The report is what the baked field does: sampled along the guides it has the stated residual.
TEST(Fit, ReportsResidualOfTheBakedField) {
  const ControlMesh box = mesh(unitBox(4, 0.1, 5));
  Guides guides = sixRolls();
  const FitResult result = Fit(box).solve(guides);
  const Refiner refiner = refine(box, FitOptions{}.levels);
  const Limit limit(refiner);
  const VectorField field =
      makeField(refiner, limit, refiner.refine(*result.flux, result.mode), result.mode);
  guides.curves.resize(1);
  double missed = 0, wanted = 0;
  for (const GuideSample& sample : sampleGuides(guides, 0.25 * 0.2, 1)) {
    Vec3 v;
    ASSERT_TRUE(field.sample(sample.point, &v));
    missed += sample.weight * (v - sample.value).squaredNorm();
    wanted += sample.weight * sample.value.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(missed / wanted), result.report.guides[0].residual,
              0.02 * result.report.guides[0].residual + 1e-4);
}

/// Two lobes and two ears of lattice cells: a curved closed surface with no creases.
ControlMeshInput bunny() {
  const auto inside = [](int x, int y, int z) {
    const auto blob = [&](double cx, double cy, double cz, double rx, double ry, double rz) {
      const double a = (x - cx) / rx, b = (y - cy) / ry, c = (z - cz) / rz;
      return a * a + b * b + c * c < 1;
    };
    return blob(0, 0, -2, 5.2, 5.2, 4.7) || blob(0, 2.5, 3.5, 3.7, 3.7, 3.2) ||
           blob(-2, 2.5, 8, 1.8, 1.8, 4) || blob(2, 2.5, 8, 1.8, 1.8, 4);
  };
  ControlMeshInput input = testing::latticeBlock(inside, 13);
  input.creases = std::vector<std::array<Index, 2>>{};
  return input;
}

TEST(Fit, FollowsSixCurvesInBunny) {
  const ControlMesh body = mesh(bunny());
  Guides guides;
  const Vec3 belly(0, 0, -2);
  int k = 0;
  for (const double radius : {1.5, 2.5}) {
    for (const double z : {-3.5, -2.0, -0.5}) {
      guides.curves.push_back(circle("ring " + std::to_string(++k), Vec3(0, 0, z), radius, radius));
    }
  }
  const FitResult result = Fit(body).solve(guides);
  for (const GuideReport& guide : result.report.guides) {
    EXPECT_LT(guide.residual, 0.05) << guide.name;
  }
  EXPECT_EQ(onBoundary(*body.complex(), *result.flux), 0.0);
  const Refiner refiner = refine(body, 1);
  EXPECT_EQ(onBoundary(refiner.finest(), refiner.refine(*result.flux, result.mode)), 0.0);
  EXPECT_LT(divergence(refiner, *result.flux, result.mode), 1e-12);
}

/// A ring of cells: the flow around it has no potential that vanishes on the wall.
TEST(Fit, FlowsAroundAHandleWithClosedWalls) {
  const auto inside = [](int x, int y, int z) {
    return std::max(std::abs(x), std::abs(y)) <= 6 && std::max(std::abs(x), std::abs(y)) >= 2 &&
           std::abs(z) <= 2;
  };
  const ControlMesh ring = mesh(testing::latticeBlock(inside, 7));
  Guides guides;
  guides.curves = {circle("around", Vec3::Zero(), 4.2, 1)};
  const FitResult result = Fit(ring).solve(guides);
  EXPECT_LT(result.report.guides[0].residual, 0.1);
  EXPECT_EQ(onBoundary(*ring.complex(), *result.flux), 0.0);
  EXPECT_LT(result.report.divergence, 1e-13);
}

/// In at the left, out at the right, by the amounts given.
TEST(Fit, KeepsGivenFluxThroughFacets) {
  const ControlMesh box = mesh(unitBox(4, 0, 1));
  const Complex& c = *box.complex();
  FitOptions options;
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (!c.facetOnBoundary(f)) continue;
    double low = 1, high = 0;
    for (const Index v : c.facetVertices(f)) {
      low = std::min(low, box.positions()[v][0]);
      high = std::max(high, box.positions()[v][0]);
    }
    if (high < 1e-9) options.flux[f] = -1.0 / 32;
    if (low > 1 - 1e-9) options.flux[f] = 1.0 / 32;
  }
  ASSERT_EQ(options.flux.size(), 64u);
  Guides guides;
  guides.curves = {line("through", Vec3(0.05, 0.5, 0.5), Vec3(0.95, 0.5, 0.5), 1)};
  for (const FitKind kind : {FitKind::DivergenceFree, FitKind::Free}) {
    options.kind = kind;
    const FitResult result = Fit(box, options).solve(guides);
    EXPECT_LT(result.report.guides[0].residual, 0.05);
    for (Index f = 0; f < c.facetCount(); ++f) {
      if (!c.facetOnBoundary(f)) continue;
      const double outward = c.facetCells[f][0].exists() ? 1 : -1;
      const auto given = options.flux.find(f);
      EXPECT_EQ((*result.flux)[f] * outward, given == options.flux.end() ? 0 : given->second);
    }
    EXPECT_EQ(result.mode, BoundaryMode::Walls);
    if (kind == FitKind::DivergenceFree) {
      EXPECT_LT(result.report.divergence, 1e-12);
    }
  }
  // More in than out.
  options.kind = FitKind::DivergenceFree;
  options.flux.begin()->second *= 2;
  EXPECT_THROW(Fit(box, options), InputError);
}

TEST(Fit, WithOpenBoundaryReproducesUniformFlow) {
  const ControlMesh ball = mesh(testing::withOctahedra(testing::randomBall(120, 9)));
  const Refiner refiner = refine(ball, 2);
  Box box;
  for (const Vec3& p : refiner.positions(2)) box.extend(p);
  const Vec3 middle = (box.min + box.max) / 2, reach = 0.25 * box.size();
  const Vec3 flow(1, 2, -0.5);
  Guides guides;
  for (const double y : {-0.5, 0.0, 0.5}) {
    const Vec3 at = middle + Vec3(0, y * reach[1], 0);
    const Vec3 along = flow.normalized() * reach.minCoeff();
    guides.curves.push_back(line("straight", at - along, at + along, flow.norm()));
  }
  FitOptions options;
  options.closedWalls = false;
  for (const FitKind kind : {FitKind::DivergenceFree, FitKind::Free, FitKind::CurlFree}) {
    options.kind = kind;
    const FitResult result = Fit(ball, options).solve(guides);
    EXPECT_LT(result.report.residual, 1e-3) << static_cast<int>(kind);
    if (kind == FitKind::CurlFree) {
      const Cochain<2> curl = d(*ball.complex(), *result.circulation);
      EXPECT_LT(maxNorm(curl.values()), 1e-13 * maxNorm(result.circulation->values()));
    }
  }
}

TEST(Fit, CurlFreeFieldSaysHowMuchPassesWalls) {
  const ControlMesh box = mesh(unitBox(3, 0, 1));
  FitOptions options;
  options.kind = FitKind::CurlFree;
  Guides guides;
  guides.curves = {line("across", Vec3(0.2, 0.5, 0.5), Vec3(0.8, 0.5, 0.5), 1)};
  const double closed = Fit(box, options).solve(guides).report.wallFlux;
  EXPECT_GT(closed, 0);
  EXPECT_LT(closed, 1);
}

TEST(Fit, SaysWhereGuidesContradictEachOther) {
  const ControlMesh box = mesh(unitBox(4, 0, 1));
  Guides guides;
  guides.curves = {line("left", Vec3(0.8, 0.5, 0.5), Vec3(0.2, 0.5, 0.5), 1),
                   line("right", Vec3(0.2, 0.5, 0.5), Vec3(0.8, 0.5, 0.5), 1),
                   line("elsewhere", Vec3(0.2, 0.2, 0.2), Vec3(0.2, 0.8, 0.2), 1)};
  const FitReport report = Fit(box).solve(guides).report;
  ASSERT_EQ(report.conflicts.size(), 1u);
  EXPECT_EQ(report.conflicts[0].first, "left");
  EXPECT_EQ(report.conflicts[0].second, "right");
  EXPECT_NEAR(report.conflicts[0].disagreement, 2, 0.01);
  EXPECT_GT(report.guides[0].residual, 0.5);
  EXPECT_FALSE(report.remarks.empty());
}

TEST(Fit, SaysThatGuidesDoNotDetermineTheField) {
  const ControlMesh box = mesh(unitBox(3, 0, 1));
  Guides guides;
  guides.vectors = {{"one", Vec3(0.4, 0.5, 0.5), Vec3(1, 0, 0), 1, "", ""}};
  const FitReport report = Fit(box).solve(guides).report;
  EXPECT_LT(report.guides[0].residual, 0.05);
  bool said = false;
  for (const std::string& remark : report.remarks) {
    said |= remark.find("under-determined") != std::string::npos;
  }
  EXPECT_TRUE(said);
  FitOptions options;
  options.smoothness = 0;
  EXPECT_THROW(Fit(box, options).solve(guides), InputError);
}

void expectRefused(const Guides& guides, const std::string& place, const std::string& reason) {
  const ControlMesh box = mesh(unitBox(2, 0, 1));
  try {
    Fit(box).solve(guides);
    ADD_FAILURE() << "accepted: " << reason;
  } catch (const InputError& e) {
    EXPECT_EQ(e.file(), "guides.csv");
    EXPECT_NE(e.place().find(place), std::string::npos) << e.what();
    EXPECT_NE(e.reason().find(reason), std::string::npos) << e.what();
  }
}

TEST(Fit, RefusesBadGuidesWithTheirLine) {
  GuideCurve curve = line("a", Vec3(0.2, 0.5, 0.5), Vec3(0.8, 0.5, 0.5), 1);
  curve.file = "guides.csv";
  for (int k = 0; k <= 8; ++k) curve.places.push_back("line " + std::to_string(k + 2));
  Guides guides;
  const auto with = [&](const auto& change) {
    guides.curves = {curve};
    change(&guides.curves[0]);
    return guides;
  };
  expectRefused(with([](GuideCurve* c) { c->points[8] = Vec3(1.5, 0.5, 0.5); }), "line 9",
                "outside");
  expectRefused(with([](GuideCurve* c) { c->points[3] = c->points[2]; }), "line 5", "zero length");
  expectRefused(with([](GuideCurve* c) { c->points[4][1] = NAN; }), "line 6", "finite");
  expectRefused(with([](GuideCurve* c) { c->speeds = {0}; }), "line 2", "speed");
  expectRefused(with([](GuideCurve* c) { c->speeds = {HUGE_VAL}; }), "line 2", "finite");
  expectRefused(with([](GuideCurve* c) { c->weight = -1; }), "line 2", "weight");
  expectRefused(with([](GuideCurve* c) { c->points.resize(1); }), "line 2", "two points");
}

TEST(Fit, GivesTheSameBytesAtAnyThreadCount) {
  const ControlMesh box = mesh(unitBox(3, 0.1, 5));
  std::vector<Array<double>> results;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(Fit(box).solve(sixRolls()).flux->values());
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(Fit, CanBeCancelled) {
  FitOptions options;
  const auto cancel = [](const ProgressReport& report) { return report.stage != "solve"; };
  EXPECT_THROW(Fit(mesh(unitBox(2, 0, 1)), options).solve(sixRolls(), cancel), Cancelled);
}

// ---- parts
// ---------------------------------------------------------------------------------------

TEST(WallPotential, HasGivenFluxWhateverTheUnknowns) {
  for (const auto& kind : testing::allKinds()) {
    const ControlMesh m = mesh(kind.input);
    const Complex& c = *m.complex();
    GivenFlux flux(static_cast<std::size_t>(c.facetCount()));
    for (Index f = 0; f < c.facetCount(); ++f) {
      if (c.facetOnBoundary(f)) flux[f] = 0;
    }
    const auto check = [&] {
      const WallPotential potential = makeWallPotential(c, flux);
      const auto x = testing::randomValues(static_cast<Index>(potential.basis.cols()), 4);
      const Eigen::VectorXd a =
          potential.basis * Eigen::Map<const Eigen::VectorXd>(x.data(), potential.basis.cols()) +
          potential.particular;
      const Cochain<2> result = d(c, Cochain<1>(Array<double>(a.data(), a.data() + a.size())));
      for (Index f = 0; f < c.facetCount(); ++f) {
        EXPECT_NEAR(result[f], flux[f].value_or(result[f]), 1e-13) << kind.name;
      }
      return potential.basis.cols();
    };
    const auto closed = check();
    // Some facets free, some with a flux that some field has.
    const auto r = testing::randomValues(c.edgeCount(), 6);
    const Cochain<2> some = d(c, Cochain<1>(Array<double>(r.begin(), r.end())));
    for (Index f = 0; f < c.facetCount(); ++f) {
      if (flux[f]) flux[f] = some[f];
    }
    EXPECT_EQ(check(), closed) << kind.name;
    for (Index f = 0; f < c.facetCount(); f += 3) flux[f].reset();
    EXPECT_GT(check(), closed) << kind.name;
  }
}

/// Direct and iterative solutions against Eigen's, over several blocks of the factorisation.
TEST(LeastSquares, BothSolversFindTheMinimum) {
  constexpr Index kUnknowns = 300, kRows = 500;
  const auto r = testing::randomValues(7 * kRows, 12);
  LeastSquares problem;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kRows, kUnknowns);
  Eigen::VectorXd right(kRows), weights(kRows);
  for (Index k = 0; k < kRows; ++k) {
    RowSum sum(kUnknowns);
    for (Index j = 0; j < 5; ++j) sum.add((k * 7 + j * j * 11) % kUnknowns, r[7 * k + j]);
    problem.rows.push_back(sum.take());
    for (std::size_t j = 0; j < problem.rows.back().size(); ++j) {
      dense(k, problem.rows.back().index[j]) = problem.rows.back().weight[j];
    }
    right[k] = r[7 * k + 5];
    weights[k] = 1.5 + r[7 * k + 6];
    problem.rights.push_back(right[k]);
    problem.weights.push_back(weights[k]);
  }
  Eigen::SparseMatrix<double> energy(kUnknowns, kUnknowns);
  energy.setIdentity();
  energy *= 1e-3;
  problem.energy = &energy;
  problem.energyPull = Eigen::VectorXd::Constant(kUnknowns, 1e-2);
  const Eigen::MatrixXd normal =
      dense.transpose() * weights.asDiagonal() * dense + Eigen::MatrixXd(energy);
  const Eigen::VectorXd want =
      normal.ldlt().solve(dense.transpose() * weights.cwiseProduct(right) + problem.energyPull);
  for (const Eigen::Index mostDirect : {kUnknowns, 0}) {
    problem.mostDirect = mostDirect;
    const LeastSquaresSolution solution = solve(problem);
    EXPECT_EQ(solution.direct, mostDirect > 0);
    EXPECT_TRUE(solution.determined);
    EXPECT_LT((solution.x - want).norm(), 1e-7 * want.norm()) << mostDirect;
  }
}

TEST(Smoothness, ChargesConstantsNothingButTheirSize) {
  const ControlMesh m = mesh(testing::withOctahedra(testing::randomBall(150, 3)));
  const Complex& c = *m.complex();
  const auto& x = m.positions();
  Eigen::VectorXd constant(c.facetCount()), bent(c.facetCount());
  for (Index f = 0; f < c.facetCount(); ++f) {
    const auto v = c.facetVertices(f);
    const Vec3 area = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 2;
    const Vec3 centre = (x[v[0]] + x[v[1]] + x[v[2]]) / 3;
    constant[f] = area[0];
    bent[f] = area[0] * std::sin(3 * centre[1]);
  }
  const auto energy = smoothnessEnergy<2>(c, x, 1.0, true, true);
  const double ofConstant = constant.dot(energy * constant);
  EXPECT_NEAR(ofConstant, 1e-6, 1e-9);  // a^2 |v|^2 / V
  EXPECT_GT(bent.dot(energy * bent), 1e-2);
}

}  // namespace
}  // namespace octet
