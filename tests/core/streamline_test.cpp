// SPDX-License-Identifier: Apache-2.0
// Streamlines: accuracy follows the tolerance, ends are where they should be, and placement is even
// and independent of threads.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <octet/core/streamlines/placement.h>

namespace octet {
namespace {

const Vec3 kAxis = Vec3(1, 2, 2) / 3;

/// Turns around an axis through the origin, once in 2 pi; everywhere.
bool rotation(const Vec3& p, Vec3* v) {
  *v = kAxis.cross(p);
  return true;
}

/// A field with curvature and torsion of its own, for which no step is exact.
bool swirl(const Vec3& p, Vec3* v) {
  *v = Vec3(1 + 0.3 * std::sin(2 * p[1]), std::cos(3 * p[0]), 0.4 * std::sin(p[0] + p[1]));
  return true;
}

StreamlineOptions timed(double tolerance, double time) {
  StreamlineOptions options;
  options.tolerance = tolerance;
  options.longestTime = time;
  return options;
}

TEST(Streamline, RigidRotationCloses) {
  const Vec3 seed(0.4, -0.7, 0.2);
  for (const double tolerance : {1e-5, 1e-8, 1e-11}) {
    for (const int direction : {1, -1}) {
      const Streamline line =
          traceStreamline(rotation, seed, timed(tolerance, 2 * M_PI), direction);
      EXPECT_EQ(line.last, StreamlineEnd::Time);
      EXPECT_EQ(line.points.back().time, direction * 2 * M_PI);
      // As many steps as it takes, each within the tolerance.
      const double steps = static_cast<double>(line.points.size());
      EXPECT_LT((line.points.back().position - seed).norm(), 2 * steps * tolerance);
      for (const StreamlinePoint& p : line.points) {
        EXPECT_NEAR(p.position.norm(), seed.norm(), 2 * steps * tolerance);
        EXPECT_NEAR(p.position.dot(kAxis), seed.dot(kAxis), 2 * steps * tolerance);
      }
    }
  }
}

TEST(Streamline, ErrorFallsWithTheToleranceAndStepsGrowAsOrderFiveDoes) {
  // Means over many lines: of one line errors may cancel by chance.
  const double tolerances[2] = {1e-6, 1e-10};
  double errors[2] = {0, 0}, steps[2] = {0, 0};
  for (const Vec3& seed : haltonPoints({Vec3(-1, -1, -1), Vec3(1, 1, 1)}, 50)) {
    const Vec3 exact = traceStreamline(swirl, seed, timed(1e-14, 3)).points.back().position;
    for (int k = 0; k < 2; ++k) {
      const Streamline line = traceStreamline(swirl, seed, timed(tolerances[k], 3));
      errors[k] += (line.points.back().position - exact).norm() / 50;
      steps[k] += static_cast<double>(line.points.size()) / 50;
    }
  }
  EXPECT_LT(errors[1], steps[1] * tolerances[1]);
  // The fourth order's error is what is controlled, h^5 ~ tolerance; the fifth order is carried on,
  // so that 1/h steps of error h^6 are left: in proportion to the tolerance.
  const double errorOrder =
      std::log(errors[0] / errors[1]) / std::log(tolerances[0] / tolerances[1]);
  const double stepOrder = std::log(steps[1] / steps[0]) / std::log(tolerances[0] / tolerances[1]);
  EXPECT_NEAR(errorOrder, 1, 0.2);
  EXPECT_NEAR(stepOrder, 0.2, 0.03);
}

TEST(Streamline, EndsAtTheBoundaryToTheTolerance) {
  const auto inBall = [](const Vec3& p, Vec3* v) { return p.norm() <= 1 && swirl(p, v); };
  StreamlineOptions options;
  options.tolerance = 1e-7;
  for (const Vec3& seed : haltonPoints({Vec3(-0.5, -0.5, -0.5), Vec3(0.5, 0.5, 0.5)}, 20)) {
    const Streamline line = traceBothWays(inBall, seed, options);
    EXPECT_EQ(line.first, StreamlineEnd::Boundary);
    EXPECT_EQ(line.last, StreamlineEnd::Boundary);
    EXPECT_EQ(line.points[line.seed].position, seed);
    EXPECT_EQ(line.points[line.seed].time, 0);
    for (const StreamlinePoint& p : line.points) EXPECT_LE(p.position.norm(), 1);
    EXPECT_GT(line.points.front().position.norm(), 1 - 3e-7);
    EXPECT_GT(line.points.back().position.norm(), 1 - 3e-7);
    for (std::size_t k = 1; k < line.points.size(); ++k) {
      EXPECT_GT(line.points[k].time, line.points[k - 1].time);
      EXPECT_GT((line.points[k].position - line.points[k - 1].position)
                    .dot(line.points[k].velocity + line.points[k - 1].velocity),
                0);
    }
  }
}

TEST(Streamline, EndsForEveryReason) {
  const Vec3 seed(1, 0, 0);
  StreamlineOptions options;
  options.longest = 2.5;
  options.longestStep = 0.01;
  Streamline line = traceStreamline(swirl, seed, options);
  EXPECT_EQ(line.last, StreamlineEnd::Length);
  EXPECT_NEAR(line.length(), 2.5, 1e-4);
  for (std::size_t k = 1; k < line.points.size(); ++k) {
    EXPECT_LE((line.points[k].position - line.points[k - 1].position).norm(), 0.0101);
  }

  options = {};
  options.closing = 0.01;
  options.longest = 100;
  line = traceBothWays(rotation, seed, options);
  EXPECT_EQ(line.last, StreamlineEnd::Closed);
  EXPECT_NEAR(line.length(), 2 * M_PI * seed.cross(kAxis).norm(), 0.2);

  const auto sink = [](const Vec3& p, Vec3* v) {
    *v = -p;
    return true;
  };
  options = {};
  options.slowest = 1e-3;
  line = traceStreamline(sink, seed, options);
  EXPECT_EQ(line.last, StreamlineEnd::Standstill);
  EXPECT_LE(line.points.back().velocity.norm(), 1e-3);

  options = {};
  options.mostSteps = 7;
  line = traceStreamline(rotation, seed, options);
  EXPECT_EQ(line.last, StreamlineEnd::Steps);
  EXPECT_LE(line.points.size(), 8u);

  const auto nowhere = [](const Vec3&, Vec3*) { return false; };
  EXPECT_TRUE(traceStreamline(nowhere, seed, {}).points.empty());
  EXPECT_TRUE(traceBothWays(nowhere, seed, {}).points.empty());
}

TEST(Streamline, StopsBeforeWhatIsNotFinite) {
  const auto broken = [](const Vec3& p, Vec3* v) {
    *v = p[0] > 0.5 ? Vec3(NAN, 0, 0) : Vec3(1, 0, 0);
    return true;
  };
  const Streamline line = traceStreamline(broken, Vec3::Zero(), {});
  EXPECT_EQ(line.last, StreamlineEnd::Boundary);
  EXPECT_NEAR(line.points.back().position[0], 0.5, 1e-5);
}

TEST(Placement, SeedsKeepTheirDistance) {
  const Box box{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  const auto inBall = [](const Vec3& p) { return p.norm() <= 1; };
  const std::vector<Vec3> points = spacedPoints(inBall, box, 200, 0.2);
  EXPECT_EQ(points.size(), 200u);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE(points[i].norm(), 1);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GE((points[i] - points[j]).norm(), 0.2);
  }

  const auto flow = [](const Vec3& p, Vec3* v) { return p.norm() <= 1 && swirl(p, v); };
  PlacementOptions options;
  options.count = 25;
  options.separation = 0.25;
  options.lines.longestStep = 0.02;
  const std::vector<Streamline> lines = placeStreamlines(flow, box, options);
  ASSERT_EQ(lines.size(), 25u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const Vec3 seed = lines[i].points[lines[i].seed].position;
    for (std::size_t j = 0; j < i; ++j) {
      // Points are denser than the separation by far.
      for (const StreamlinePoint& p : lines[j].points) {
        EXPECT_GE((p.position - seed).norm(), 0.25) << i << " " << j;
      }
    }
  }
}

TEST(Placement, DoesNotDependOnThreads) {
  const Box box{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  const auto flow = [](const Vec3& p, Vec3* v) { return p.norm() <= 1 && swirl(p, v); };
  PlacementOptions options;
  options.count = 40;
  options.separation = 0.1;
  std::vector<std::vector<Streamline>> results;
  for (const int threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(placeStreamlines(flow, box, options));
  }
  for (std::size_t r = 1; r < results.size(); ++r) {
    ASSERT_EQ(results[r].size(), results[0].size());
    for (std::size_t i = 0; i < results[r].size(); ++i) {
      ASSERT_EQ(results[r][i].points.size(), results[0][i].points.size());
      for (std::size_t k = 0; k < results[r][i].points.size(); ++k) {
        EXPECT_EQ(results[r][i].points[k].position, results[0][i].points[k].position);
      }
    }
  }
}

TEST(Placement, CanBeCancelled) {
  PlacementOptions options;
  const auto cancel = [](const ProgressReport&) { return false; };
  EXPECT_THROW(placeStreamlines(rotation, {Vec3(0, 0, 0), Vec3(1, 1, 1)}, options, cancel),
               Cancelled);
}

}  // namespace
}  // namespace octet
