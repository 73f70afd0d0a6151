// SPDX-License-Identifier: Apache-2.0
// Surfaces filled and fitted: whatever the body, the cage is a valid manifold with a regular
// interior, boundary vertices lie on the surface, no cell is inverted; what encloses nothing is
// refused.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <octet/converters/surface/fill_surface.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/cell_shape.h>
#include <octet/core/cage/nesting.h>
#include <octet/core/cage/quality.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/meshes.h"
#include "tests/support/surfaces.h"

namespace octet {
namespace {

using namespace testing;

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
  const ControlMesh mesh =
      fitted(boxSurface(boxOf(Vec3(0, 0, 0), Vec3(2, 1.7, 0.5))), 0.2, &report);
  EXPECT_NEAR(volumeOf(mesh), 1.7, 0.12);
  FillOptions options;
  options.spacing = 0.2;
  try {
    fillSurface(boxSurface(boxOf(Vec3(0, 0, 0), Vec3(2, 1.7, 0.1))), options);
    FAIL() << "a plate thinner than the lattice was filled";
  } catch (const InputError& e) {
    EXPECT_NE(e.reason().find("too coarse"), std::string::npos) << e.what();
  }
}

/// Length of the creases, whose vertices must all lie on the surface's sharp edges.
double creaseLength(const ControlMesh& mesh, const TriangleSurface& surface) {
  TriangleSurface lines;
  for (const TriangleSurface& chain : chainsAsSurfaces(surface, findSharpEdges(surface))) {
    lines = joined(lines, chain);
  }
  const ClosestPoints closest(lines);
  const Complex& c = *mesh.complex();
  double length = 0;
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (!(c.edgeFlags[e] & kOnCrease)) continue;
    const Vec3 &a = mesh.positions()[c.edges[e][0]], &b = mesh.positions()[c.edges[e][1]];
    EXPECT_LT(closest.find(a).distance, 1e-9);
    EXPECT_LT(closest.find(b).distance, 1e-9);
    length += (b - a).norm();
  }
  return length;
}

/// A cube's and an L's cages keep all edges and corners, through subdivision too.
TEST(FillSurface, FitsFollowStraightSharpEdges) {
  struct Case {
    TriangleSurface surface;
    double spacing, sharp, volume;
    std::size_t corners;
  };
  const TriangleSurface cube = boxSurface(boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)));
  for (const auto& [surface, spacing, sharp, volume, corners] :
       {Case{cube, 0.25, 12, 1, 8}, Case{cube, 0.12, 12, 1, 8},
        Case{ellSurface(), 0.23, 22, 3, 12}}) {
    FillReport report;
    const ControlMesh mesh = fitted(surface, spacing, &report);
    EXPECT_NEAR(creaseLength(mesh, surface), sharp, 1e-9);
    EXPECT_NEAR(report.creaseLength, sharp, 1e-9);
    EXPECT_NEAR(report.sharpLength, sharp, 1e-12);
    EXPECT_EQ(mesh.corners().size(), corners);
    EXPECT_NEAR(volumeOf(mesh), volume, 1e-9);
    RefinerOptions options;
    options.levels = 1;
    const Refiner refiner(mesh, options);
    const Complex& c = refiner.finest();
    double refined = 0;
    for (Index cell = 0; cell < c.cellCount(); ++cell) {
      refined += c.cellSigns[cell] * cellVolume6(c, refiner.positions(1), cell) / 6;
    }
    EXPECT_NEAR(refined, volume, 1e-9);
  }
}

TEST(FillSurface, FitsFollowMostOfAnySharpEdge) {
  for (const double spacing : {0.4, 0.3, 0.2}) {
    const TriangleSurface surface = cylinder(1, 3, 128);
    FillReport report;
    const ControlMesh mesh = fitted(surface, spacing, &report);
    EXPECT_GT(creaseLength(mesh, surface), 0.95 * 4 * M_PI);
    EXPECT_TRUE(mesh.corners().empty());
  }
  // What is not followed keeps the fit that there would be without.
  FillReport report;
  const ControlMesh ell = fitted(ellSurface(), 0.12, &report);
  EXPECT_GT(creaseLength(ell, ellSurface()), 0.8 * 22);
  EXPECT_EQ(report.fit->offSurface.size(), 0u);
}

TEST(FillSurface, FitsHaveNoCreasesWhereNoneAreWanted) {
  FillOptions options;
  options.spacing = 0.25;
  options.fitBoundary = true;
  options.sharpAngle = 91;
  FillReport report;
  const TriangleSurface cube = boxSurface(boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1)));
  EXPECT_EQ(creaseLength(fillSurface(cube, options, &report), cube), 0);
  EXPECT_EQ(report.sharpLength, 0);
  options.sharpAngle = 0;
  EXPECT_THROW(fillSurface(cube, options), InputError);
  fitted(blob(2), 0.25, &report);
  EXPECT_EQ(report.creaseLength, 0);
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
  const TriangleSurface box = boxSurface(boxOf(Vec3(-1, -1, -1), Vec3(1, 1, 1)));
  const ClosestPoints closest(box);
  const auto r = randomValues(3 * 500, 9);
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
