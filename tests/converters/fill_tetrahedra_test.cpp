// SPDX-License-Identifier: Apache-2.0
// Cages of tetrahedra: whatever the body, its boundary lies on the surface, its creases follow the
// sharp edges, and its cells are well shaped and fill what the surface encloses.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <octet/converters/gmsh/fill_tetrahedra.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/quality.h>
#include <octet/core/refine/refiner.h>
#include <octet/core/topology/boundary.h>

#include "tests/support/meshes.h"
#include "tests/support/surfaces.h"

namespace octet {
namespace {

using namespace testing;

TriangleSurface cube() { return boxSurface(boxOf(Vec3(0, 0, 0), Vec3(1, 1, 1))); }

/// Fills, and checks what every fill of a remeshed surface promises.
ControlMesh filled(const TriangleSurface& surface, double spacing, TetrahedraReport* report) {
  TetrahedraOptions options;
  options.spacing = spacing;
  ControlMesh mesh = fillWithTetrahedra(surface, options, report);
  const Complex& c = *mesh.complex();
  EXPECT_EQ(c.octCount(), 0);
  EXPECT_TRUE(report->remeshed);
  const CageQuality quality = measureQuality(c, mesh.positions());
  EXPECT_EQ(quality.touchingVertices, 0);
  EXPECT_EQ(quality.touchingEdges, 0);
  EXPECT_EQ(quality.components, report->bodies);
  EXPECT_GT(quality.minDihedral, 10);
  EXPECT_LT(quality.maxDihedral, 165);
  EXPECT_GT(quality.minShape, 0.03);
  const ClosestPoints closest(surface);
  double sum = 0;
  for (Index v = 0; v < c.vertexCount(); ++v) {
    if (!c.vertexOnBoundary(v)) continue;
    EXPECT_LT(closest.find(mesh.positions()[v]).distance, 1e-12);
  }
  for (const auto& [a, b] : c.edges) sum += (mesh.positions()[a] - mesh.positions()[b]).norm();
  EXPECT_NEAR(sum / c.edgeCount(), spacing, 0.15 * spacing);
  return mesh;
}

/// Length of the creases, all of which must lie along an axis.
double creasesAlongAxes(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  double length = 0;
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (!(c.edgeFlags[e] & kOnCrease)) continue;
    const Vec3 d = mesh.positions()[c.edges[e][1]] - mesh.positions()[c.edges[e][0]];
    EXPECT_EQ((d.array() == 0).count(), 2) << d.transpose();
    length += d.norm();
  }
  return length;
}

Index cornerCount(const ControlMesh& mesh) {
  const Boundary boundary(*mesh.complex(), mesh.corners(), nullptr);
  return static_cast<Index>(
      std::count(boundary.kinds.begin(), boundary.kinds.end(), BoundaryKind::Corner));
}

double refinedVolume(const ControlMesh& mesh, int levels) {
  RefinerOptions options;
  options.levels = levels;
  const Refiner refiner(mesh, options);
  const Complex& c = refiner.finest();
  double volume = 0;
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    volume += c.cellSigns[cell] * cellVolume6(c, refiner.positions(levels), cell) / 6;
  }
  return volume;
}

TEST(FillWithTetrahedra, ACubeKeepsItsEdgesAndCornersThroughSubdivision) {
  for (const double spacing : {0.4, 0.17}) {
    TetrahedraReport report;
    const ControlMesh mesh = filled(cube(), spacing, &report);
    EXPECT_NEAR(volumeOf(mesh), 1, 1e-12);
    EXPECT_NEAR(creasesAlongAxes(mesh), 12, 1e-12);
    EXPECT_NEAR(report.sharpLength, 12, 1e-12);
    EXPECT_NEAR(report.creaseLength, 12, 1e-12);
    EXPECT_EQ(cornerCount(mesh), 8);
    EXPECT_NEAR(refinedVolume(mesh, 2), 1, 1e-12);
  }
}

TEST(FillWithTetrahedra, AnEllIsExact) {
  TetrahedraReport report;
  const ControlMesh mesh = filled(ellSurface(), 0.23, &report);
  EXPECT_NEAR(volumeOf(mesh), 3, 1e-12);
  EXPECT_NEAR(creasesAlongAxes(mesh), 22, 1e-12);
  EXPECT_EQ(cornerCount(mesh), 12);
  EXPECT_NEAR(refinedVolume(mesh, 1), 3, 1e-12);
}

TEST(FillWithTetrahedra, NestedShellsAreBodiesAndCavities) {
  for (const bool reversed : {false, true}) {
    const TriangleSurface shell = joined(ball(1), ball(0.6), reversed);
    const TriangleSurface all = joined(joined(shell, ball(0.35)), ball(0.7, Vec3(3, 0, 0)));
    TetrahedraReport report;
    const ControlMesh mesh = filled(all, 0.14, &report);
    EXPECT_EQ(report.bodies, 3);
    EXPECT_EQ(report.cavities, 1);
    const double body = 4 * M_PI / 3 * (1 - 0.216 + 0.042875 + 0.343);
    EXPECT_NEAR(report.bodyVolume, body, 0.01 * body);
    EXPECT_NEAR(volumeOf(mesh), body, 0.03 * body);
    const Complex& c = *mesh.complex();
    for (Index cell = 0; cell < c.cellCount(); ++cell) {
      Vec3 centre = Vec3::Zero();
      for (int i = 0; i < 4; ++i) centre += mesh.positions()[c.cellVertex(cell, i)] / 4;
      EXPECT_FALSE(centre.norm() > 0.35 && centre.norm() < 0.58) << "in the cavity";
    }
  }
}

class Bodies : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(Bodies, OfAnySmoothShapeAreFilled) {
  const TriangleSurface surface = GetParam() == 0 ? bunnyLike() : blob(GetParam());
  TetrahedraReport report;
  const ControlMesh mesh = filled(surface, 0.2, &report);
  EXPECT_NEAR(volumeOf(mesh), std::abs(surface.volume()), 0.03 * std::abs(surface.volume()));
  EXPECT_LT(report.surfaceDistance, 0.4 * 0.2);  // facets bridge grooves
  EXPECT_EQ(creasesAlongAxes(mesh), 0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Bodies, ::testing::Range(0u, 4u));

TEST(FillWithTetrahedra, CylindersHaveTwoRingsOfCreases) {
  TetrahedraReport report;
  const ControlMesh mesh = filled(cylinder(1, 2, 128), 0.25, &report);
  EXPECT_NEAR(report.creaseLength, 4 * M_PI, 0.05);
  EXPECT_EQ(cornerCount(mesh), 0);
  EXPECT_NEAR(volumeOf(mesh), 2 * M_PI, 0.1);
}

TEST(FillWithTetrahedra, KeepsTrianglesThatSuitOrWhenTold) {
  TetrahedraOptions options;
  options.spacing = 0.5;
  TetrahedraReport report;
  const TriangleSurface coarse = boxSurface(boxOf(Vec3(0, 0, 0), Vec3(0.5, 0.5, 0.5)));
  const ControlMesh mesh = fillWithTetrahedra(coarse, options, &report);
  EXPECT_FALSE(report.remeshed);
  EXPECT_EQ(cornerCount(mesh), 8);
  options.spacing = 0.1;
  options.keepTriangles = true;
  const ControlMesh kept = fillWithTetrahedra(ball(1, Vec3::Zero(), 8), options, &report);
  EXPECT_FALSE(report.remeshed);
  Index facets = 0;
  for (Index f = 0; f < kept.complex()->facetCount(); ++f) {
    facets += kept.complex()->facetOnBoundary(f);
  }
  EXPECT_EQ(facets, static_cast<Index>(ball(1, Vec3::Zero(), 8).triangles.size()));
}

TEST(FillWithTetrahedra, CreasesAreWhatTheAngleSays) {
  TetrahedraOptions options;
  options.spacing = 0.5;
  options.sharpAngle = 91;
  EXPECT_EQ(creasesAlongAxes(fillWithTetrahedra(cube(), options)), 0);
  options.sharpAngle = 89;
  EXPECT_NEAR(creasesAlongAxes(fillWithTetrahedra(cube(), options)), 12, 1e-12);
}

TEST(FillWithTetrahedra, RefusesWhatItCannotFill) {
  const auto refused = [](const TriangleSurface& surface, const std::string& reason,
                          double spacing = 0.25, double angle = 40) {
    TetrahedraOptions options;
    options.spacing = spacing;
    options.sharpAngle = angle;
    try {
      fillWithTetrahedra(surface, options);
      ADD_FAILURE() << "filled, although " << reason;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(reason), std::string::npos) << e.what();
    }
  };
  refused(TriangleSurface{}, "no triangles");
  TriangleSurface bad = ball(1);
  bad.triangles.pop_back();
  refused(bad, "not closed");
  bad = ball(1);
  bad.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
  refused(bad, "not a finite number");
  bad = ball(1);
  bad.triangles[3][0] = 1000000;
  refused(bad, "out of range");
  refused(joined(ball(1), ball(0.7, Vec3(1, 0, 0))), "intersects itself");
  refused(joined(cube(), boxSurface(boxOf(Vec3(1, 1, 0), Vec3(2, 2, 1)))), "two triangles");
  refused(joined(cube(), boxSurface(boxOf(Vec3(1, 1, 1), Vec3(2, 2, 2)))), "touches itself");
  refused(ball(1), "too coarse", 5);
  refused(joined(ball(1), ball(0.97)), "too coarse", 0.5);
  refused(ball(1), "too fine", 1e-4);
  refused(ball(1), "not a positive number", -1);
  refused(ball(1), "not a positive number", std::numeric_limits<double>::quiet_NaN());
  refused(ball(1), "not between", 0.25, 0);
}

TEST(FillWithTetrahedra, IsCancelledAtEveryStage) {
  std::vector<std::string> stages;
  TetrahedraOptions options;
  options.spacing = 0.3;
  const auto listen = [&](const ProgressReport& report) {
    if (stages.empty() || stages.back() != report.stage) stages.push_back(report.stage);
    return true;
  };
  fillWithTetrahedra(ball(1), options, nullptr, listen);
  EXPECT_EQ(stages,
            (std::vector<std::string>{"check surface", "remesh surface", "mesh with Gmsh"}));
  for (const std::string& stage : stages) {
    const auto stop = [&](const ProgressReport& report) { return report.stage != stage; };
    EXPECT_THROW(fillWithTetrahedra(ball(1), options, nullptr, stop), Cancelled) << stage;
  }
}

}  // namespace
}  // namespace octet
