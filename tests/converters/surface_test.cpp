// SPDX-License-Identifier: Apache-2.0
// Surfaces filled and fitted: whatever the body, the cage is a valid manifold with a regular
// interior, boundary vertices lie on the surface, no cell is inverted; what encloses nothing is
// refused.
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include <octet/converters/surface/fill_surface.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/cell_shape.h>
#include <octet/core/cage/nesting.h>
#include <octet/core/cage/quality.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

/// A closed surface over the parameters of a torus (`closedPoles` false) or a sphere.
TriangleSurface surfaceOf(int n, int m, bool sphere,
                          const std::function<Vec3(double, double)>& at) {
  TriangleSurface s;
  const int rows = sphere ? n - 1 : n;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < m; ++j) {
      const double u = sphere ? M_PI * (i + 1) / n : 2 * M_PI * i / n;
      s.vertices.push_back(at(u, 2 * M_PI * j / m));
    }
  }
  const auto id = [&](int i, int j) { return static_cast<Index>((i % rows) * m + j % m); };
  for (int i = 0; i < (sphere ? rows - 1 : rows); ++i) {
    for (int j = 0; j < m; ++j) {
      s.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      s.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  if (!sphere) return s;
  const Index top = static_cast<Index>(s.vertices.size()), bottom = top + 1;
  s.vertices.push_back(at(0, 0));
  s.vertices.push_back(at(M_PI, 0));
  for (int j = 0; j < m; ++j) {
    s.triangles.push_back({top, id(0, j), id(0, j + 1)});
    s.triangles.push_back({bottom, id(rows - 1, j + 1), id(rows - 1, j)});
  }
  return s;
}

Vec3 direction(double u, double v) {
  return {std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u)};
}

TriangleSurface ball(double radius, const Vec3& centre = Vec3::Zero(), int n = 32) {
  return surfaceOf(n, 2 * n, true,
                   [&](double u, double v) -> Vec3 { return centre + radius * direction(u, v); });
}

TriangleSurface torus() {
  return surfaceOf(64, 32, false, [](double u, double v) {
    const double r = 1 + 0.35 * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), 0.35 * std::sin(v));
  });
}

/// A ball with random bumps and dents, a few waves around it.
TriangleSurface blob(std::uint32_t seed) {
  const auto r = testing::randomValues(24, seed);
  return surfaceOf(48, 96, true, [r](double u, double v) -> Vec3 {
    const Vec3 p = direction(u, v);
    double radius = 1;
    for (int k = 0; k < 6; ++k) {
      const Vec3 q(r[4 * k], r[4 * k + 1], r[4 * k + 2]);
      radius += 0.09 * std::sin(4 * q.dot(p) + 3 * r[4 * k + 3]);
    }
    return radius * p;
  });
}

TriangleSurface boxSurface(const Vec3& a, const Vec3& b) {
  TriangleSurface s;
  for (int k = 0; k < 8; ++k) {
    s.vertices.emplace_back(k & 1 ? b[0] : a[0], k & 2 ? b[1] : a[1], k & 4 ? b[2] : a[2]);
  }
  constexpr Index kQuads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                  {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : kQuads) {
    s.triangles.push_back({q[0], q[1], q[2]});
    s.triangles.push_back({q[0], q[2], q[3]});
  }
  return s;
}

TriangleSurface joined(TriangleSurface a, const TriangleSurface& b, bool reversed = false) {
  const Index first = static_cast<Index>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (auto t : b.triangles) {
    for (Index& v : t) v += first;
    if (reversed) std::swap(t[0], t[1]);
    a.triangles.push_back(t);
  }
  return a;
}

double volumeOf(const ControlMesh& mesh) {
  double volume = 0;
  for (Index cell = 0; cell < mesh.complex()->cellCount(); ++cell) {
    volume += std::abs(cellVolume6(*mesh.complex(), mesh.positions(), cell)) / 6;
  }
  return volume;
}

void expectRegularAndManifold(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  for (Index v = 0; v < c.vertexCount(); ++v) {
    ASSERT_EQ(c.vertexTypes[v], c.vertexOnBoundary(v) ? VertexType::B3 : VertexType::R) << v;
  }
  const CageQuality quality = measureQuality(c, mesh.positions());
  EXPECT_EQ(quality.touchingVertices, 0);
  EXPECT_EQ(quality.touchingEdges, 0);
}

/// Fills and fits, and checks what every fit promises.
ControlMesh fitted(const TriangleSurface& surface, double spacing, FillReport* report) {
  FillOptions options;
  options.spacing = spacing;
  options.fitBoundary = true;
  ControlMesh mesh = fillSurface(surface, options, report);
  expectRegularAndManifold(mesh);
  const Complex& c = *mesh.complex();
  const double edge = spacing * spacing * spacing;
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    const double regular = (c.isTet(cell) ? kTetCorner6 : kOctCorner6) * edge;
    EXPECT_GT(measureShape(c, mesh.positions(), cell).minVolume6, 0.049 * regular);
  }
  const ClosestPoints closest(surface);
  Index off = 0;
  double furthest = 0;
  for (Index v = 0; v < c.vertexCount(); ++v) {
    if (!c.vertexOnBoundary(v)) continue;
    const double distance = closest.find(mesh.positions()[v]).distance;
    off += distance > 2e-3 * spacing;
    furthest = std::max(furthest, distance);
  }
  EXPECT_LE(off, static_cast<Index>(report->fit->offSurface.size()));
  EXPECT_NEAR(furthest, report->fit->maxAfter, 1e-12);
  return mesh;
}

class Blob : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(Blob, IsFilledRegularlyAndFittedWithoutInversion) {
  const TriangleSurface surface = blob(GetParam());
  for (const double spacing : {0.31, 0.18}) {
    FillReport report;
    const ControlMesh mesh = fitted(surface, spacing, &report);
    EXPECT_EQ(report.fit->offSurface.size(), 0u);
    EXPECT_NEAR(volumeOf(mesh), surface.volume(), 0.15 * spacing * surface.volume());
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Blob, ::testing::Range(1u, 7u));

TEST(FillSurface, ATorusKeepsItsHole) {
  FillReport report;
  const ControlMesh mesh = fitted(torus(), 0.16, &report);
  const Complex& c = *mesh.complex();
  // Euler's characteristic of a solid torus is 0.
  EXPECT_EQ(c.vertexCount() - c.edgeCount() + c.facetCount() - c.cellCount(), 0);
  EXPECT_EQ(report.fit->offSurface.size(), 0u);
}

TEST(FillSurface, PartsWithinPartsAreCavitiesWhicheverWayTheyTurn) {
  for (const bool reversed : {false, true}) {
    const TriangleSurface shell = joined(ball(1), ball(0.5), reversed);
    FillReport report;
    const ControlMesh mesh = fitted(joined(shell, ball(0.7, Vec3(3, 0, 0))), 0.15, &report);
    EXPECT_EQ(report.bodies, 2);
    EXPECT_EQ(report.cavities, 1);
    EXPECT_EQ(report.lattice.components, 2);
    const double body = 4 * M_PI / 3 * (1 - 0.125 + 0.343);
    EXPECT_NEAR(report.bodyVolume, body, 0.01 * body);
    EXPECT_NEAR(volumeOf(mesh), body, 0.03 * body);
  }
  const auto layers = nestingLayers(joined(joined(ball(1), ball(0.6)), ball(0.3)));
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_NEAR(layers[2].volume, ball(0.3).volume(), 1e-12);
}

TEST(FillSurface, PlatesKeepTheirThicknessAndThinOnesAreRefused) {
  FillReport report;
  const ControlMesh mesh = fitted(boxSurface(Vec3(0, 0, 0), Vec3(2, 1.7, 0.5)), 0.2, &report);
  EXPECT_NEAR(volumeOf(mesh), 1.7, 0.12);
  FillOptions options;
  options.spacing = 0.2;
  try {
    fillSurface(boxSurface(Vec3(0, 0, 0), Vec3(2, 1.7, 0.1)), options);
    FAIL() << "a plate thinner than the lattice was filled";
  } catch (const InputError& e) {
    EXPECT_NE(e.reason().find("too coarse"), std::string::npos) << e.what();
  }
}

TEST(FillSurface, ResultDoesNotDependOnWhereTheBodyIs) {
  FillReport report;
  const ControlMesh here = fitted(blob(3), 0.25, &report);
  TriangleSurface far = blob(3);
  for (Vec3& p : far.vertices) p += Vec3(1024, -512, 2048);
  const ControlMesh there = fitted(far, 0.25, &report);
  ASSERT_EQ(here.complex()->tets, there.complex()->tets);
  EXPECT_EQ(here.complex()->octs, there.complex()->octs);
}

TEST(FillSurface, RefusesWhatEnclosesNothing) {
  const auto refused = [](const TriangleSurface& surface, const std::string& reason,
                          double spacing = 0.2) {
    FillOptions options;
    options.spacing = spacing;
    try {
      fillSurface(surface, options);
      ADD_FAILURE() << "filled, although " << reason;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    }
  };
  refused(TriangleSurface{}, "no triangles");
  TriangleSurface open = ball(1);
  open.triangles.pop_back();
  refused(open, "not closed");
  TriangleSurface broken = ball(1);
  broken.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
  refused(broken, "not a finite number");
  broken = ball(1);
  broken.triangles[3][0] = 1000000;
  refused(broken, "out of range");
  refused(joined(ball(1), ball(0.7, Vec3(1, 0, 0))), "intersects itself");
  TriangleSurface twisted = torus();
  for (Vec3& p : twisted.vertices) p[0] = std::abs(p[0] - 0.3);
  refused(twisted, "intersects itself");
  refused(ball(1), "too coarse", 5);
  refused(ball(1), "too fine", 1e-5);
  refused(ball(1), "not a positive number", -1);
  refused(ball(1), "not a positive number", std::numeric_limits<double>::quiet_NaN());
}

TEST(FillSurface, FillsWhatIntersectingPartsEncloseWhenTold) {
  FillOptions options;
  options.spacing = 0.12;
  options.allowIntersections = true;
  FillReport report;
  const ControlMesh mesh = fillSurface(joined(ball(1), ball(0.7, Vec3(1, 0, 0))), options, &report);
  expectRegularAndManifold(mesh);
  EXPECT_EQ(report.lattice.components, 1);
}

TEST(ClosestPoints, AreExactOnABox) {
  const TriangleSurface box = boxSurface(Vec3(-1, -1, -1), Vec3(1, 1, 1));
  const ClosestPoints closest(box);
  const auto r = testing::randomValues(3 * 500, 9);
  for (int k = 0; k < 500; ++k) {
    const Vec3 p = 2 * Vec3(r[3 * k], r[3 * k + 1], r[3 * k + 2]);
    const Vec3 clamped = p.cwiseMax(-1).cwiseMin(1);
    const double outside = (p - clamped).norm();
    const double expected = outside > 0 ? outside : 1 - p.cwiseAbs().maxCoeff();
    EXPECT_NEAR(closest.find(p).distance, expected, 1e-14);
    EXPECT_NEAR((closest.find(p).position - p).norm(), expected, 1e-14);
  }
}

}  // namespace
}  // namespace octet
