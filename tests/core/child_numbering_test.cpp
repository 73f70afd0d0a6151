// SPDX-License-Identifier: Apache-2.0
// Children are numbered without gaps and their numbers lead back, on meshes of any kind.
#include <algorithm>
#include <cctype>
#include <vector>

#include <gtest/gtest.h>

#include <octet/core/topology/control_mesh.h>
#include <octet/core/topology/split.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

/// Collects children's numbers, and checks that each leads back to where it came from.
class Hits {
 public:
  explicit Hits(std::int64_t count) : hits_(static_cast<std::size_t>(count), 0) {}

  void add(Index child, const ChildOf& back, Origin origin, Index parent, int place) {
    ASSERT_GE(child, 0);
    ASSERT_LT(static_cast<std::size_t>(child), hits_.size());
    ++hits_[static_cast<std::size_t>(child)];
    EXPECT_EQ(back.origin, origin) << "child " << child;
    EXPECT_EQ(back.parent, parent) << "child " << child;
    EXPECT_EQ(back.place, place) << "child " << child;
  }
  /// Was every number given once?
  bool each() const {
    return std::all_of(hits_.begin(), hits_.end(), [](int n) { return n == 1; });
  }

 private:
  std::vector<int> hits_;
};

class ChildNumberingOf : public ::testing::TestWithParam<testing::NamedMesh> {
 protected:
  std::shared_ptr<const Complex> complex() const {
    return ControlMesh::build(GetParam().input).complex();
  }
};

TEST_P(ChildNumberingOf, VerticesAndEdgesLeadBack) {
  const auto coarse = complex();
  const Complex& c = *coarse;
  const ChildNumbering n = c.children();
  Hits vertices(n.vertexCount()), edges(n.edgeCount());
  for (Index v = 0; v < c.vertexCount(); ++v) vertices.add(v, n.vertex(v), Origin::Vertex, v, 0);
  for (Index e = 0; e < c.edgeCount(); ++e) {
    vertices.add(n.midpoint(e), n.vertex(n.midpoint(e)), Origin::Edge, e, 0);
    for (int k = 0; k < 2; ++k) edges.add(n.half(e, k), n.edge(n.half(e, k)), Origin::Edge, e, k);
  }
  for (Index f = 0; f < c.facetCount(); ++f) {
    for (int k = 0; k < 3; ++k) edges.add(n.cut(f, k), n.edge(n.cut(f, k)), Origin::Facet, f, k);
  }
  for (Index o = 0; o < c.octCount(); ++o) {
    vertices.add(n.centre(o), n.vertex(n.centre(o)), Origin::Octahedron, o, 0);
    for (int k = 0; k < 12; ++k) {
      edges.add(n.spoke(o, k), n.edge(n.spoke(o, k)), Origin::Octahedron, o, k);
    }
  }
  EXPECT_TRUE(vertices.each());
  EXPECT_TRUE(edges.each());
}

TEST_P(ChildNumberingOf, FacetsAndCellsLeadBack) {
  const auto coarse = complex();
  const Complex& c = *coarse;
  const ChildNumbering n = c.children();
  Hits facets(n.facetCount()), cells(n.cellCount());
  const auto addFacet = [&](Index child, Origin origin, Index parent, int place) {
    facets.add(child, n.facet(child), origin, parent, place);
  };
  const auto addCell = [&](Index child, Origin origin, Index parent, int place) {
    cells.add(child, n.cell(child), origin, parent, place);
    EXPECT_EQ(n.parentCell(child), origin == Origin::Octahedron ? c.tetCount() + parent : parent);
  };
  for (Index f = 0; f < c.facetCount(); ++f) {
    for (int k = 0; k < 4; ++k) addFacet(n.onFacet(f, k), Origin::Facet, f, k);
  }
  Index inside = 0;  // those of tetrahedra come before those of octahedra
  for (Index t = 0; t < c.tetCount(); ++t) {
    for (int k = 0; k < 4; ++k) {
      addFacet(n.inTet(t, k), Origin::Tetrahedron, t, k);
      EXPECT_EQ(n.insideNumber(n.inTet(t, k)), inside++);
      addCell(n.cornerTet(t, k), Origin::Tetrahedron, t, k);
      EXPECT_EQ(n.cornerChild(t, k), n.cornerTet(t, k));
    }
    addCell(n.innerOct(t), Origin::Tetrahedron, t, 0);
    EXPECT_EQ(n.innerChild(t, 3), n.innerOct(t));
  }
  for (Index o = 0; o < c.octCount(); ++o) {
    for (int k = 0; k < 24; ++k) {
      addFacet(n.inOct(o, k), Origin::Octahedron, o, k);
      EXPECT_EQ(n.insideNumber(n.inOct(o, k)), inside++);
    }
    for (int k = 0; k < 8; ++k) {
      addCell(n.innerTet(o, k), Origin::Octahedron, o, k);
      EXPECT_EQ(n.innerChild(c.tetCount() + o, k), n.innerTet(o, k));
    }
    for (int k = 0; k < 6; ++k) {
      addCell(n.cornerOct(o, k), Origin::Octahedron, o, k);
      EXPECT_EQ(n.cornerChild(c.tetCount() + o, k), n.cornerOct(o, k));
    }
  }
  EXPECT_TRUE(facets.each());
  EXPECT_TRUE(cells.each());
}

// The numbers mean what they say: by the vertices of the children.
TEST_P(ChildNumberingOf, ChildrenLieWhereTheNumbersSay) {
  const auto coarse = complex();
  const auto fine = split(coarse);
  const Complex &c = *coarse, &f = *fine;
  const ChildNumbering n = c.children();
  EXPECT_EQ(f.vertexCount(), n.vertexCount());
  EXPECT_EQ(f.edgeCount(), n.edgeCount());
  EXPECT_EQ(f.facetCount(), n.facetCount());
  EXPECT_EQ(f.tetCount(), n.tetCount());
  EXPECT_EQ(f.octCount(), n.octCount());
  for (Index e = 0; e < c.edgeCount(); ++e) {
    for (int end = 0; end < 2; ++end) {
      EXPECT_EQ(f.edges[n.half(e, end)][end], c.edges[e][end]);
      EXPECT_EQ(f.edges[n.half(e, end)][1 - end], n.midpoint(e));
    }
  }
  for (Index facet = 0; facet < c.facetCount(); ++facet) {
    const auto corners = c.facetVertices(facet);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(f.facetVertices(n.onFacet(facet, k))[k], corners[k]);
      // The edge that cuts a corner off is in the facet that keeps it, and in the middle one.
      for (const int at : {k, 3}) {
        const auto& edges = f.facetEdges[n.onFacet(facet, at)];
        EXPECT_TRUE(std::any_of(edges.begin(), edges.end(),
                                [&](const EdgeRef& e) { return e.index() == n.cut(facet, k); }));
      }
    }
  }
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    for (int k = 0; k < c.cellVertexCount(cell); ++k) {
      EXPECT_EQ(f.cellVertex(n.cornerChild(cell, k), k), c.cellVertex(cell, k));
    }
  }
  for (Index o = 0; o < c.octCount(); ++o) {
    for (int k = 0; k < 12; ++k) {
      const std::array<Index, 2> spoke = {n.centre(o), n.midpoint(c.octEdge(o, k).index())};
      EXPECT_EQ(f.edges[n.spoke(o, k)], spoke);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, ChildNumberingOf, ::testing::ValuesIn(testing::allKinds()),
                         [](const auto& mesh) {
                           std::string name = mesh.param.name;
                           std::replace_if(
                               name.begin(), name.end(), [](char ch) { return !std::isalnum(ch); },
                               '_');
                           return name;
                         });

}  // namespace
}  // namespace octet
