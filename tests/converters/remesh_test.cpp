// SPDX-License-Identifier: Apache-2.0
// Sharp edges and remeshing: whatever the surface, the triangles become about as long as wanted,
// stay on the surface, and follow its sharp edges from corner to corner.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <octet/converters/gmsh/remesh.h>
#include <octet/core/base/error.h>

#include "tests/support/meshes.h"
#include "tests/support/surfaces.h"

namespace octet {
namespace {

using namespace testing;

TriangleSurface cube() { return boxSurface(boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1))); }

double length(const TriangleSurface& s, Index a, Index b) {
  return (s.vertices[a] - s.vertices[b]).norm();
}

double creaseLength(const RemeshedSurface& r) {
  double sum = 0;
  for (const auto& [a, b] : r.creases) sum += length(r.surface, a, b);
  return sum;
}

/// V - E + F: 2 for each sphere, 0 for each torus.
Index euler(const TriangleSurface& s) {
  return static_cast<Index>(s.vertices.size()) - static_cast<Index>(s.triangles.size()) / 2;
}

std::vector<double> edgeLengths(const TriangleSurface& s) {
  std::vector<double> lengths;
  for (const auto& t : s.triangles) {
    for (int k = 0; k < 3; ++k) lengths.push_back(length(s, t[k], t[(k + 1) % 3]));
  }
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

double smallestAngle(const TriangleSurface& s) {
  double smallest = 180;
  for (const auto& t : s.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = s.vertices[t[(k + 1) % 3]] - s.vertices[t[k]];
      const Vec3 b = s.vertices[t[(k + 2) % 3]] - s.vertices[t[k]];
      smallest = std::min(smallest, std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI);
    }
  }
  return smallest;
}

struct Case {
  const char* name;
  TriangleSurface surface;
  double edge;
};

std::vector<Case> cases() {
  return {{"cube_coarser", cube(), 0.09},
          {"ell", ellSurface(), 0.21},
          {"ball_finer", ball(1), 0.3},
          {"ball_coarser", ball(1, Vec3::Zero(), 6), 0.11},
          {"torus", torus(), 0.15},
          {"bunny_like", bunnyLike(), 0.2},
          {"blob", blob(3), 0.17},
          {"needles", cylinder(1, 4, 128), 0.25},
          {"nested", joined(ball(1), ball(0.5)), 0.2}};
}

class Remeshed : public ::testing::TestWithParam<Case> {};

TEST_P(Remeshed, IsOnTheSurfaceWithEdgesAsLongAsWanted) {
  const auto& [name, surface, edge] = GetParam();
  RemeshOptions options;
  options.edgeLength = edge;
  const RemeshedSurface r = remesh(surface, options);
  EXPECT_NO_THROW(checkClosed(r.surface));
  EXPECT_FALSE(findSelfIntersection(r.surface));
  EXPECT_EQ(euler(r.surface), euler(surface));
  EXPECT_NEAR(r.surface.volume(), surface.volume(), edge * edge * std::abs(surface.volume()));
  const ClosestPoints closest(surface);
  for (const Vec3& p : r.surface.vertices) EXPECT_LT(closest.find(p).distance, 1e-12);
  const std::vector<double> lengths = edgeLengths(r.surface);
  EXPECT_NEAR(lengths[lengths.size() / 2], edge, 0.2 * edge);
  EXPECT_GT(lengths[lengths.size() / 20], 0.6 * edge);
  EXPECT_LT(lengths.back(), 1.6 * edge);
  EXPECT_GT(smallestAngle(r.surface), 15);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, Remeshed, ::testing::ValuesIn(cases()),
                         [](const auto& c) { return std::string(c.param.name); });

TEST(Remesh, FollowsStraightSharpEdgesExactly) {
  for (const double edge : {0.4, 0.13, 0.06}) {
    RemeshOptions options;
    options.edgeLength = edge;
    const RemeshedSurface r = remesh(cube(), options);
    EXPECT_NEAR(creaseLength(r), 12, 1e-12);
    EXPECT_EQ(r.corners.size(), 8u);
    EXPECT_NEAR(std::abs(r.surface.volume()), 1, 1e-12);
    const RemeshedSurface ell = remesh(ellSurface(), options);
    EXPECT_NEAR(creaseLength(ell), 22, 1e-12);
    EXPECT_EQ(ell.corners.size(), 12u);
    EXPECT_NEAR(std::abs(ell.surface.volume()), 3, 1e-12);
  }
}

TEST(Remesh, FollowsCurvedSharpEdgesWithChords) {
  RemeshOptions options;
  options.edgeLength = 0.2;
  const RemeshedSurface r = remesh(cylinder(1, 2, 128), options);
  EXPECT_TRUE(r.corners.empty());
  for (const auto& edge : r.creases) {
    for (const Index v : edge) {
      EXPECT_NEAR(r.surface.vertices[v].head<2>().norm(), 1, 3.1e-4);  // of the given chords
      EXPECT_TRUE(r.surface.vertices[v][2] == 0 || r.surface.vertices[v][2] == 2);
    }
  }
  EXPECT_NEAR(creaseLength(r), 4 * M_PI, 0.03);
}

/// Two flat pyramids on an octagon: sharp edges meet in twos at its corners, where they turn by 45
/// degrees.
TEST(Remesh, KeepsCornersOfTwoSharpEdges) {
  TriangleSurface surface;
  constexpr Index n = 8;
  for (Index k = 0; k < n; ++k) {
    const double angle = 2 * M_PI * k / n;
    surface.vertices.push_back(Vec3(std::cos(angle), std::sin(angle), 0));
    surface.triangles.push_back({k, (k + 1) % n, n});
    surface.triangles.push_back({(k + 1) % n, k, n + 1});
  }
  surface.vertices.push_back(Vec3(0, 0, 0.5));
  surface.vertices.push_back(Vec3(0, 0, -0.5));
  for (const double edge : {0.35, 0.12}) {
    RemeshOptions options;
    options.edgeLength = edge;
    const RemeshedSurface r = remesh(surface, options);
    EXPECT_EQ(r.corners.size(), 8u);
    EXPECT_NEAR(creaseLength(r), 2 * n * std::sin(M_PI / n), 1e-12);
    for (const auto& crease : r.creases) {
      for (const Index v : crease) EXPECT_EQ(r.surface.vertices[v][2], 0);
    }
  }
}

TEST(Remesh, DoesNotDependOnOrientation) {
  TriangleSurface turned = bunnyLike();
  const auto random = randomValues(static_cast<Index>(turned.triangles.size()), 4);
  for (std::size_t t = 1; t < random.size(); ++t) {
    if (random[t] < 0) std::swap(turned.triangles[t][0], turned.triangles[t][1]);
  }
  RemeshOptions options;
  options.edgeLength = 0.25;
  const RemeshedSurface r = remesh(turned, options);
  EXPECT_NEAR(std::abs(r.surface.volume()), std::abs(bunnyLike().volume()), 0.2);
}

TEST(Remesh, RefusesWhatIsNoManifold) {
  RemeshOptions options;
  options.edgeLength = 0.3;
  const auto refused = [&](const TriangleSurface& surface, const std::string& reason) {
    try {
      remesh(surface, options);
      ADD_FAILURE() << "remeshed, although " << reason;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    }
  };
  const auto two = [](const Vec3& at) {
    return welded(joined(cube(), boxSurface(boxOf(at, at + Vec3(1, 1, 1)))));
  };
  refused(two(Vec3(1, 1, 0)), "instead of two triangles");
  refused(two(Vec3(1, 1, 1)), "touches itself");
  TriangleSurface open = cube();
  open.triangles.pop_back();
  refused(open, "not closed");
  // Klein's bottle: rows of a torus, joined back to front.
  constexpr int n = 12;
  TriangleSurface bottle;
  for (int i = 0; i < n * n; ++i) bottle.vertices.emplace_back(i / n, i % n, (i / n) * (i % n));
  const auto id = [](int i, int j) {
    return static_cast<Index>((i % n) * n + (i == n ? (2 * n - j) % n : j % n));
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      bottle.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      bottle.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  refused(bottle, "one-sided");
}

/// A vertex on an edge of the cube that only one of the faces there knows of: between them lies a
/// triangle without height, or of a height that is rounding.
TEST(Remesh, SliversHideNoSharpEdge) {
  for (const double height : {0.0, 1e-9}) {
    TriangleSurface surface = cube();
    surface.vertices.push_back(Vec3(0.4, height, 0));  // on (0, 1), which two triangles share
    const Index m = 8;
    const auto has = [](const std::array<Index, 3>& t, Index v) {
      return std::find(t.begin(), t.end(), v) != t.end();
    };
    const auto at = std::find_if(surface.triangles.begin(), surface.triangles.end(),
                                 [&](const auto& t) { return has(t, 0) && has(t, 1); });
    std::array<Index, 3> first = *at, second = *at;
    std::replace(first.begin(), first.end(), Index{1}, m);
    std::replace(second.begin(), second.end(), Index{0}, m);
    *at = first;
    surface.triangles.push_back(second);
    surface.triangles.push_back({0, 1, m});
    EXPECT_NO_THROW(checkClosed(surface));
    const TriangleSurface mended = withoutSlivers(surface);
    EXPECT_EQ(mended.triangles.size(), 14u);
    const SharpEdges sharp = findSharpEdges(mended);
    double length = 0;
    for (const auto& [a, b] : sharp.edges)
      length += (mended.vertices[b] - mended.vertices[a]).norm();
    EXPECT_NEAR(length, 12, 1e-8);
    EXPECT_EQ(sharp.corners.size(), 8u);
  }
}

TEST(SharpEdges, OfACubeAreTwelveChainsBetweenEightCorners) {
  for (const bool reversed : {false, true}) {
    TriangleSurface surface = cube();
    if (reversed) std::swap(surface.triangles[5][0], surface.triangles[5][2]);
    const SharpEdges sharp = findSharpEdges(surface);
    EXPECT_EQ(sharp.edges.size(), 12u);
    EXPECT_EQ(sharp.chainCount, 12);
    EXPECT_EQ(sharp.corners.size(), 8u);
    EXPECT_EQ(findSharpEdges(surface, 89).edges.size(), 12u);
    EXPECT_TRUE(findSharpEdges(surface, 91).edges.empty());
  }
}

TEST(SharpEdges, OfACylinderAreTwoRingsUnlessTheyAreShort) {
  const TriangleSurface surface = cylinder(1, 2, 64);
  const SharpEdges sharp = findSharpEdges(surface);
  EXPECT_EQ(sharp.edges.size(), 128u);
  EXPECT_EQ(sharp.chainCount, 2);
  EXPECT_TRUE(sharp.corners.empty());
  EXPECT_EQ(findSharpEdges(surface, kSharpAngle, 6.2).edges.size(), 128u);
  EXPECT_TRUE(findSharpEdges(surface, kSharpAngle, 6.3).edges.empty());
}

TEST(Remesh, IsDeterministic) {
  RemeshOptions options;
  options.edgeLength = 0.2;
  const TriangleSurface surface = cylinder(1, 2, 128);
  const RemeshedSurface first = remesh(surface, options), second = remesh(surface, options);
  EXPECT_EQ(first.surface.triangles, second.surface.triangles);
  EXPECT_EQ(first.surface.vertices, second.surface.vertices);
  EXPECT_EQ(first.creases, second.creases);
}

TEST(Oriented, TrianglesAgreeWithTheirNeighbours) {
  TriangleSurface turned = torus();
  const auto random = randomValues(static_cast<Index>(turned.triangles.size()), 7);
  for (std::size_t t = 0; t < random.size(); ++t) {
    if (random[t] < 0) std::swap(turned.triangles[t][0], turned.triangles[t][1]);
  }
  const TriangleSurface result = oriented(turned);
  EXPECT_EQ(result.vertices, turned.vertices);
  EXPECT_NEAR(std::abs(result.volume()), std::abs(torus().volume()), 1e-12);
  EXPECT_GT(std::abs(std::abs(turned.volume()) - std::abs(torus().volume())), 0.1);
}

}  // namespace
}  // namespace octet
