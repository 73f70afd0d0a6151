// SPDX-License-Identifier: Apache-2.0
// The split is the one of SCHEME.md section 3: counts, closed-form numbering, stored orientation.
#include <map>
#include <set>

#include <gtest/gtest.h>

#include <octet/core/topology/control_mesh.h>
#include <octet/core/topology/split.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

std::shared_ptr<const Complex> complexOf(const ControlMeshInput& input) {
  return ControlMesh::build(input).complex();
}

TEST(Split, SingleCellsHaveTheThesisCounts) {
  const auto tet = split(complexOf(testing::singleTetrahedron()));
  EXPECT_EQ(tet->vertexCount(), 10);
  EXPECT_EQ(tet->edgeCount(), 24);
  EXPECT_EQ(tet->facetCount(), 20);
  EXPECT_EQ(tet->tetCount(), 4);
  EXPECT_EQ(tet->octCount(), 1);
  const auto oct = split(complexOf(testing::singleOctahedron()));
  EXPECT_EQ(oct->vertexCount(), 19);
  EXPECT_EQ(oct->edgeCount(), 60);
  EXPECT_EQ(oct->facetCount(), 56);
  EXPECT_EQ(oct->tetCount(), 8);
  EXPECT_EQ(oct->octCount(), 6);
}

TEST(Split, TetrahedronIsNumberedAsTabled) {
  // Vertices a b c d = 0 1 2 3; edges ab ac ad bc bd cd, so midpoints 4 5 6 7 8 9.
  const auto f = split(complexOf(testing::singleTetrahedron()));
  const auto& edges = f->edges;
  EXPECT_EQ(edges[0], (std::array<Index, 2>{0, 4}));
  EXPECT_EQ(edges[1], (std::array<Index, 2>{4, 1}));
  EXPECT_EQ(edges[12], (std::array<Index, 2>{4, 5}));  // facet abc: (ab,ac) (ab,bc) (ac,bc)
  EXPECT_EQ(edges[13], (std::array<Index, 2>{4, 7}));
  EXPECT_EQ(edges[14], (std::array<Index, 2>{5, 7}));
  using Facet = std::array<Index, 3>;
  EXPECT_EQ(f->facetVertices(0), (Facet{0, 4, 5}));
  EXPECT_EQ(f->facetVertices(1), (Facet{4, 1, 7}));
  EXPECT_EQ(f->facetVertices(2), (Facet{5, 7, 2}));
  EXPECT_EQ(f->facetVertices(3), (Facet{4, 7, 5}));
  EXPECT_EQ(f->facetVertices(16), (Facet{4, 5, 6}));
  EXPECT_EQ(f->facetVertices(19), (Facet{6, 8, 9}));
  using Tet = std::array<Index, 4>;
  EXPECT_EQ(f->tets[0], (Tet{0, 4, 5, 6}));
  EXPECT_EQ(f->tets[1], (Tet{4, 1, 7, 8}));
  EXPECT_EQ(f->tets[2], (Tet{5, 7, 2, 9}));
  EXPECT_EQ(f->tets[3], (Tet{6, 8, 9, 3}));
  EXPECT_EQ(f->octs[0], (std::array<Index, 6>{4, 5, 6, 8, 7, 9}));
}

class SplitOf : public ::testing::TestWithParam<testing::NamedMesh> {};

TEST_P(SplitOf, EveryIncidenceIsConsistent) {
  auto complex = complexOf(GetParam().input);
  for (int level = 0; level < 3; ++level) {
    const Complex& c = *complex;
    std::set<std::set<Index>> edges, facets;
    for (const auto& e : c.edges) edges.insert({e[0], e[1]});
    EXPECT_EQ(static_cast<Index>(edges.size()), c.edgeCount()) << "an edge is there twice";
    for (Index f = 0; f < c.facetCount(); ++f) {
      const auto v = c.facetVertices(f);
      facets.insert({v[0], v[1], v[2]});
      for (int k = 0; k < 3; ++k) {
        const EdgeRef e = c.facetEdges[f][k];
        EXPECT_EQ(c.edges[e.index()][e.reversed() ? 1 : 0], v[k]);
        EXPECT_EQ(c.edges[e.index()][e.reversed() ? 0 : 1], v[(k + 1) % 3]);
      }
      // Out of one cell at most, into one at most.
      EXPECT_TRUE(c.facetCells[f][0].exists() || c.facetCells[f][1].exists());
    }
    EXPECT_EQ(static_cast<Index>(facets.size()), c.facetCount()) << "a facet is there twice";
    for (Index cell = 0; cell < c.cellCount(); ++cell) {
      const auto* table = c.isTet(cell) ? Tetrahedron::facets : Octahedron::facets;
      for (int k = 0; k < c.cellFacetCount(cell); ++k) {
        const FacetRef facet = c.cellFacet(cell, k);
        const auto v = c.facetVertices(facet.index());
        for (int j = 0; j < 3; ++j) {
          EXPECT_EQ(v[static_cast<std::size_t>(facet.place(j))], c.cellVertex(cell, table[k][j]));
        }
      }
    }
    complex = split(complex);
  }
}

TEST_P(SplitOf, StarsAreComplete) {
  const auto fine = split(split(complexOf(GetParam().input)));
  const Complex& c = *fine;
  std::map<Index, std::multiset<Index>> atVertex, atEdge;
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      atVertex[c.cellVertex(cell, i)].insert(cell);
      for (int j = i + 1; j < c.cellVertexCount(cell); ++j) {
        if (!c.isTet(cell) && Octahedron::opposite[i] == j) continue;
        atEdge[c.cellEdge(cell, i, j).index()].insert(cell);
      }
    }
  }
  for (Index v = 0; v < c.vertexCount(); ++v) {
    std::multiset<Index> star;
    c.visitVertexStar(v, [&](const CellAtVertex& at) {
      star.insert(at.cell);
      EXPECT_EQ(c.cellVertex(at.cell, at.place), v);
    });
    EXPECT_EQ(star, atVertex[v]);
  }
  for (Index e = 0; e < c.edgeCount(); ++e) {
    std::multiset<Index> star;
    c.visitEdgeStar(e, [&](const CellAtEdge& at) {
      star.insert(at.cell);
      EXPECT_EQ(c.cellVertex(at.cell, at.start), c.edges[e][0]);
      EXPECT_EQ(c.cellVertex(at.cell, at.end), c.edges[e][1]);
    });
    EXPECT_EQ(star, atEdge[e]);
  }
}

TEST_P(SplitOf, OrientationIsInheritedRightly) {
  // In the linear split (no smoothing) geometry still tells each cell's orientation.
  const ControlMesh mesh = ControlMesh::build(GetParam().input);
  Array<Vec3> x = mesh.positions();
  const auto fine = split(mesh.complex());
  const Complex& c = *mesh.complex();
  for (const auto& [a, b] : c.edges) x.push_back((x[a] + x[b]) / 2);
  for (const auto& oct : c.octs) {
    Vec3 centre = Vec3::Zero();
    for (const Index v : oct) centre += x[v] / 6;
    x.push_back(centre);
  }
  // A concave octahedron's centroid can lie outside; its children are then folded.
  if (GetParam().name.find("concave") != std::string::npos) GTEST_SKIP();
  Index wrong = 0;
  for (Index cell = 0; cell < fine->cellCount(); ++cell) {
    if (fine->cellSigns[cell] * cellVolume6(*fine, x, cell) <= 0) ++wrong;
  }
  if (GetParam().name.find("mixed") == std::string::npos) {
    EXPECT_EQ(wrong, 0);
  } else {
    EXPECT_LT(wrong, fine->cellCount() / 50);  // octahedra of random shape may be concave
  }
}

TEST_P(SplitOf, VertexTypesAreThoseOfWhereVerticesLie) {
  const auto control = complexOf(GetParam().input);
  const auto one = split(control);
  const Complex& c = *control;
  for (Index v = 0; v < c.vertexCount(); ++v) EXPECT_EQ(one->vertexTypes[v], c.vertexTypes[v]);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    const VertexType type = one->vertexTypes[c.vertexCount() + e];
    if (c.edgeOnBoundary(e)) {
      EXPECT_EQ(type, VertexType::B2);
    } else {
      EXPECT_TRUE(type == VertexType::X2 || type == VertexType::R);
    }
  }
  const auto two = split(one);
  for (Index k = 0; k < 3 * c.facetCount(); ++k) {
    const VertexType type = two->vertexTypes[one->vertexCount() + 2 * c.edgeCount() + k];
    if (c.facetOnBoundary(k / 3)) {
      EXPECT_EQ(type, VertexType::B1);
    } else {
      EXPECT_TRUE(type == VertexType::X1 || type == VertexType::R);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, SplitOf, ::testing::ValuesIn(testing::allKinds()),
                         [](const auto& mesh) {
                           std::string name = mesh.param.name;
                           for (char& ch : name) {
                             if (!std::isalnum(static_cast<unsigned char>(ch))) ch = '_';
                           }
                           return name;
                         });

TEST(Regions, ALatticeIsOneRegionHoweverItIsOrdered) {
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 9; };
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const auto complex =
        complexOf(testing::shuffled(testing::latticeBlock(ball, 3, 0.1, seed), seed));
    const std::set<Index> regions(complex->cellRegions.begin(), complex->cellRegions.end());
    // Every tetrahedron|octahedron facet joins; cells without such facets stay alone.
    std::map<Index, Index> sizes;
    for (const Index r : complex->cellRegions) ++sizes[r];
    Index largest = 0;
    for (const auto& [r, n] : sizes) largest = std::max(largest, n);
    EXPECT_GT(largest, complex->cellCount() * 9 / 10);
  }
}

TEST(Regions, WhatDoesNotCloseUpIsTakenApart) {
  // Three tetrahedra and three octahedra in turn around an edge close up in no lattice: there are
  // two of each around every lattice edge.
  ControlMeshInput mesh;
  mesh.vertices = {Vec3(0, 0, -1), Vec3(0, 0, 1)};
  const auto around = [](double turn, double r, double z) {
    return Vec3(r * std::cos(turn), r * std::sin(turn), z);
  };
  const double step = 2 * 3.14159265358979323846 / 3;
  for (int k = 0; k < 3; ++k) {
    // A tetrahedron from turn k*step to k*step + 1, an octahedron on to the next.
    mesh.vertices.push_back(around(k * step, 1, 0));
    mesh.vertices.push_back(around(k * step + 1, 1, 0));
  }
  for (int k = 0; k < 3; ++k) {
    const Index p = 2 + 2 * k, q = 3 + 2 * k, next = 2 + 2 * ((k + 1) % 3);
    mesh.tets.push_back({0, 1, p, q});
    // Edge (0,1) is not a diagonal: opposite 0 and 1 lie two new vertices further out.
    const double middle = k * step + 1 + (step - 1) / 2;
    const Index far0 = static_cast<Index>(mesh.vertices.size());
    mesh.vertices.push_back(around(middle, 2, 1));
    mesh.vertices.push_back(around(middle, 2, -1));
    mesh.octs.push_back({0, 1, q, far0 + 1, next, far0});
  }
  mesh.creases.emplace();
  const auto complex = complexOf(mesh);
  const std::set<Index> regions(complex->cellRegions.begin(), complex->cellRegions.end());
  EXPECT_GT(regions.size(), 1u);
  EXPECT_NE(complex->cellRegions[0], complex->cellRegions[1]);
}

}  // namespace
}  // namespace octet
