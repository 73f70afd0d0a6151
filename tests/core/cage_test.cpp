// SPDX-License-Identifier: Apache-2.0
// Cages: whatever body is filled, interior vertices are regular and the boundary is a manifold;
// boxes have exactly flat walls.
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>
#include <octet/core/cage/lattice_fill.h>
#include <octet/core/cage/quality.h>
#include <octet/core/cage/star_patterns.h>
#include <octet/core/topology/boundary.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

Box boxAround(double x, double y, double z) {
  Box box;
  box.extend(Vec3(-x, -y, -z));
  box.extend(Vec3(x, y, z));
  return box;
}

/// Interior vertices are R, boundary vertices B3, and the solid nowhere touches itself.
void expectRegularAndManifold(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  for (Index v = 0; v < c.vertexCount(); ++v) {
    EXPECT_EQ(c.vertexTypes[v], c.vertexOnBoundary(v) ? VertexType::B3 : VertexType::R) << v;
  }
  const CageQuality quality = measureQuality(c, mesh.positions());
  EXPECT_EQ(quality.touchingVertices, 0);
  EXPECT_EQ(quality.touchingEdges, 0);
}

TEST(StarPatterns, AllOrNothingAndSingleCellsAreManifold) {
  const StarPatterns patterns;
  EXPECT_TRUE(patterns.manifold(0));
  EXPECT_TRUE(patterns.manifold(StarPatterns::kAll));
  EXPECT_EQ(patterns.around().size(), 18u);
  for (int c = 0; c < StarPatterns::kCells; ++c) {
    EXPECT_TRUE(patterns.manifold(static_cast<std::uint16_t>(1u << c))) << c;
    EXPECT_EQ(patterns.vertices(c).size(), c < StarPatterns::kTets ? 3u : 5u);
  }
  // Two tetrahedra across from each other share the vertex only, neighbouring ones an edge.
  EXPECT_FALSE(patterns.manifold(1u << 0 | 1u << 7));
  EXPECT_FALSE(patterns.manifold(1u << 0 | 1u << 1));
  // A tetrahedron and an octahedron that share a facet are one solid.
  EXPECT_TRUE(patterns.manifold(1u << 0 | 1u << 8));
}

/// The pattern table says what the quality measure finds on the mesh of these cells.
TEST(StarPatterns, AgreeWithTheMeshOfTheirCells) {
  const StarPatterns patterns;
  for (unsigned cells = 1; cells < StarPatterns::kAll; cells += 37) {
    ControlMeshInput mesh;
    mesh.creases.emplace();
    mesh.vertices.push_back(Vec3::Zero());
    for (const Int3& p : patterns.around()) mesh.vertices.emplace_back(p[0], p[1], p[2]);
    const auto number = [&](const Int3& p) {
      for (Index k = 1; k < 19; ++k) {
        if (mesh.vertices[k] == Vec3(p[0], p[1], p[2])) return k;
      }
      return kNone;
    };
    for (int c = 0; c < StarPatterns::kCells; ++c) {
      if (!(cells >> c & 1)) continue;
      const auto& v = patterns.vertices(c);
      if (c < StarPatterns::kTets) {
        mesh.tets.push_back({0, number(v[0]), number(v[1]), number(v[2])});
        continue;
      }
      // The vertex across is the one twice as far; the others are two pairs of opposites.
      const auto across = std::find_if(v.begin(), v.end(), [](const Int3& p) {
        return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] == 4;
      });
      std::vector<Int3> ring;
      for (const Int3& p : v) {
        if (p != *across) ring.push_back(p);
      }
      mesh.octs.push_back(
          {0, number(ring[0]), number(ring[2]), number(ring[1]), number(ring[3]), number(*across)});
    }
    const ControlMesh built = ControlMesh::build(mesh);
    // At the centre vertex only; elsewhere cells may touch as they like.
    const Boundary boundary(*built.complex(), {}, nullptr);
    const auto row = boundary.row(0);
    int rings = 0;
    bool pinched = false;
    for (const RingStep* s = boundary.ringBegin(row); s != boundary.ringEnd(row); ++s) {
      pinched |= !s->firstOfEdge;
      const RingStep* next = s + 1 == boundary.ringEnd(row) ? boundary.ringBegin(row) : s + 1;
      const auto& edges = built.complex()->facetEdges[s->facet];
      rings += std::none_of(edges.begin(), edges.end(),
                            [&](const EdgeRef& e) { return e.index() == next->edge.index(); });
    }
    EXPECT_EQ(patterns.manifold(static_cast<std::uint16_t>(cells)), rings == 0 && !pinched)
        << cells;
  }
}

/// A sum of smooth bumps: bodies of any shape and number of parts, with thin necks.
SignedDistance metaballs(std::uint32_t seed) {
  const std::vector<double> r = testing::randomValues(24, seed);
  return [r](const Vec3& p) {
    double sum = 0;
    for (int k = 0; k < 6; ++k) {
      const Vec3 centre(1.2 * r[4 * k], 1.2 * r[4 * k + 1], 1.2 * r[4 * k + 2]);
      const double radius = 0.35 + 0.2 * r[4 * k + 3];
      sum += std::exp(-(p - centre).squaredNorm() / (radius * radius));
    }
    return 0.5 * (0.4 - sum);
  };
}

class FillOf : public ::testing::TestWithParam<std::uint32_t> {};

TEST_P(FillOf, RandomBodiesIsRegularWithManifoldBoundary) {
  for (const double spacing : {0.3, 0.17}) {
    LatticeFillOptions options;
    options.spacing = spacing;
    options.depth = 0.2;
    LatticeFillReport report;
    const ControlMesh mesh = ControlMesh::build(
        fillLattice(boxAround(2, 2, 2), metaballs(GetParam()), options, &report));
    expectRegularAndManifold(mesh);
    const CageQuality quality = measureQuality(*mesh.complex(), mesh.positions());
    EXPECT_EQ(quality.components, report.components);
    EXPECT_NEAR(quality.minDihedral, std::acos(1.0 / 3) * 180 / M_PI, 1e-9);
    EXPECT_NEAR(quality.maxDihedral, 180 - std::acos(1.0 / 3) * 180 / M_PI, 1e-9);
    EXPECT_NEAR(quality.minShape, 1, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, FillOf, ::testing::Range(1u, 13u));

/// Noise at the scale of the lattice leaves no place that is not repaired.
TEST(Fill, OfNoiseIsManifold) {
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const auto noise = testing::randomValues(40 * 40 * 40, seed);
    const auto distance = [&](const Vec3& p) {
      const auto at = [](double x) { return static_cast<int>(std::llround(4 * (x + 4))) % 40; };
      return noise[(at(p[0]) * 40 + at(p[1])) * 40 + at(p[2])];
    };
    LatticeFillOptions options;
    options.spacing = std::sqrt(2.0) / 4;
    options.depth = 0.1 + 0.3 * seed;
    LatticeFillReport report;
    const ControlMesh mesh =
        ControlMesh::build(fillLattice(boxAround(2, 2, 2), distance, options, &report));
    EXPECT_GT(report.added + report.dropped, 0);
    expectRegularAndManifold(mesh);
  }
}

TEST(Fill, OfABallConvergesToItsVolume) {
  const auto ball = [](const Vec3& p) { return p.norm() - 1; };
  for (const double spacing : {0.3, 0.1}) {
    LatticeFillOptions options;
    options.spacing = spacing;
    const ControlMesh mesh = ControlMesh::build(fillLattice(boxAround(1, 1, 1), ball, options));
    double volume = 0;
    for (Index cell = 0; cell < mesh.complex()->cellCount(); ++cell) {
      volume += std::abs(cellVolume6(*mesh.complex(), mesh.positions(), cell)) / 6;
    }
    EXPECT_NEAR(volume, 4 * M_PI / 3, spacing);
    for (Index v = 0; v < mesh.complex()->vertexCount(); ++v) {
      if (mesh.complex()->vertexOnBoundary(v)) {
        EXPECT_NEAR(mesh.positions()[v].norm(), 1, spacing);
      }
    }
  }
}

TEST(Fill, RefusesBadSpacings) {
  const auto ball = [](const Vec3& p) { return p.norm() - 1; };
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double spacing : {0.0, -1.0, kNan, HUGE_VAL, 3.0, 1e-4, 1e-300}) {
    LatticeFillOptions options;
    options.spacing = spacing;
    EXPECT_THROW(fillLattice(boxAround(1, 1, 1), ball, options), InputError) << spacing;
  }
}

class BoxCage : public ::testing::TestWithParam<double> {};

TEST_P(BoxCage, HasFlatWallsAndOnlyRegularInteriorVertices) {
  Box box;
  box.extend(Vec3(-0.3, 0.1, 7));
  box.extend(Vec3(1.7, 1.4, 7.9));
  const ControlMesh mesh = ControlMesh::build(boxCage(box, GetParam()));
  expectRegularAndManifold(mesh);
  const Complex& c = *mesh.complex();
  double volume = 0;
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    volume += std::abs(cellVolume6(c, mesh.positions(), cell)) / 6;
  }
  EXPECT_NEAR(volume, box.size().prod(), 1e-12);
  int creases = 0;
  for (Index e = 0; e < c.edgeCount(); ++e) {
    int walls = 0;
    for (int k = 0; k < 3; ++k) {
      for (const double wall : {box.min[k], box.max[k]}) {
        walls += mesh.positions()[c.edges[e][0]][k] == wall &&
                 mesh.positions()[c.edges[e][1]][k] == wall;
      }
    }
    EXPECT_EQ((c.edgeFlags[e] & kOnBoundary) != 0, walls > 0);
    EXPECT_EQ((c.edgeFlags[e] & kOnCrease) != 0, walls == 2);
    creases += walls == 2;
  }
  EXPECT_GE(creases, 12);
  const Boundary boundary(c, mesh.corners(), nullptr);
  EXPECT_EQ(std::count(boundary.kinds.begin(), boundary.kinds.end(), BoundaryKind::Corner), 8);
}

INSTANTIATE_TEST_SUITE_P(Spacings, BoxCage, ::testing::Values(10.0, 0.5, 0.3, 0.1));

TEST(BoxCage, RefusesBadInput) {
  const double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double spacing : {0.0, -1.0, kNan, HUGE_VAL, 1e-4, 1e-300}) {
    EXPECT_THROW(boxCage(boxAround(1, 1, 1), spacing), InputError) << spacing;
  }
  EXPECT_THROW(boxCage(Box{}, 1), InputError);
  EXPECT_THROW(boxCage(boxAround(1, 0, 1), 1), InputError);
  EXPECT_THROW(boxCage(boxAround(1, HUGE_VAL, 1), 1), InputError);
}

}  // namespace
}  // namespace octet
