// SPDX-License-Identifier: Apache-2.0
// The boundary of a refined mesh is an ordinary subdivision surface: Loop's, as OpenSubdiv has it,
// with creases and corners; refined positions and limits.
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>

#include <octet/core/field/limit.h>

#include "tests/support/meshes.h"

namespace octet {
namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

/// A point that OpenSubdiv can average.
struct Point {
  Vec3 p = Vec3::Zero();
  void Clear() { p.setZero(); }
  void AddWithWeight(const Point& other, float w) { p += w * other.p; }
  void AddWithWeight(const Point& other, double w) { p += w * other.p; }
};

/// Our boundary as OpenSubdiv's control mesh, refined by it.
class LoopSurface {
 public:
  LoopSurface(const Refiner& refiner, int levels) {
    const Complex& c = refiner.complex(0);
    const Boundary& boundary = refiner.boundary(0);
    std::vector<int> sizes(boundary.facets.size(), 3), indices, creases, corners;
    for (const Index f : boundary.facets) {
      auto v = c.facetVertices(f);
      if (!c.facetCells[f][0].exists()) std::swap(v[1], v[2]);
      for (const Index x : v) indices.push_back(boundary.row(x));
    }
    for (const Index e : boundary.edges) {
      if (!(c.edgeFlags[e] & kOnCrease)) continue;
      for (const Index v : c.edges[e]) creases.push_back(boundary.row(v));
    }
    for (Index row = 0; row < boundary.vertexCount(); ++row) {
      if (boundary.kinds[row] == BoundaryKind::Corner) corners.push_back(row);
    }
    const std::vector<float> creaseWeights(creases.size() / 2, 10),
        cornerWeights(corners.size(), 10);
    Far::TopologyDescriptor descriptor;
    descriptor.numVertices = static_cast<int>(boundary.vertices.size());
    descriptor.numFaces = static_cast<int>(boundary.facets.size());
    descriptor.numVertsPerFace = sizes.data();
    descriptor.vertIndicesPerFace = indices.data();
    descriptor.numCreases = static_cast<int>(creaseWeights.size());
    descriptor.creaseVertexIndexPairs = creases.data();
    descriptor.creaseWeights = creaseWeights.data();
    descriptor.numCorners = static_cast<int>(corners.size());
    descriptor.cornerVertexIndices = corners.data();
    descriptor.cornerWeights = cornerWeights.data();
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    refiner_.reset(Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_LOOP, Sdc::Options())));
    Far::TopologyRefiner::UniformOptions options(levels);
    options.fullTopologyInLastLevel = true;
    refiner_->RefineUniform(options);
    std::vector<Point> points(boundary.vertices.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      points[k].p = refiner.positions(0)[boundary.vertices[k]];
    }
    levels_.push_back(points);
    const Far::PrimvarRefinerReal<double> primvars(*refiner_);
    for (int level = 1; level <= levels; ++level) {
      std::vector<Point> next(static_cast<std::size_t>(refiner_->GetLevel(level).GetNumVertices()));
      primvars.Interpolate(level, levels_.back(), next);
      levels_.push_back(std::move(next));
    }
    limit_.resize(levels_.back().size());
    primvars.Limit(levels_.back(), limit_);
  }

  const std::vector<Point>& points(int level) const { return levels_[level]; }
  const std::vector<Point>& limit() const { return limit_; }

 private:
  std::unique_ptr<Far::TopologyRefiner> refiner_;
  std::vector<std::vector<Point>> levels_;
  std::vector<Point> limit_;
};

/// Expects for every point of `some` one of `all` in the same place.
void expectAmong(const std::vector<Vec3>& some, const std::vector<Vec3>& all) {
  for (const Vec3& p : some) {
    double nearest = HUGE_VAL;
    for (const Vec3& q : all) nearest = std::min(nearest, (q - p).norm());
    EXPECT_LT(nearest, 1e-6);  // OpenSubdiv computes its masks with floats
  }
}

/// Both sets of points are the same, whatever their order.
void expectSamePoints(const std::vector<Point>& expected, const std::vector<Vec3>& actual) {
  ASSERT_EQ(expected.size(), actual.size());
  std::vector<Vec3> points;
  for (const Point& q : expected) points.push_back(q.p);
  expectAmong(points, actual);
  expectAmong(actual, points);
}

void expectLoop(const ControlMeshInput& input) {
  constexpr int kLevels = 2;
  RefinerOptions options;
  options.levels = kLevels;
  options.boundaryRows = BoundaryRows::Loop;
  const Refiner refiner(ControlMesh::build(input), options);
  const LoopSurface surface(refiner, kLevels);
  const Limit limit(refiner);
  for (int level = 1; level <= kLevels; ++level) {
    std::vector<Vec3> ours;
    for (const Index v : refiner.boundary(level).vertices) {
      ours.push_back(refiner.positions(level)[v]);
    }
    expectSamePoints(surface.points(level), ours);
  }
  std::vector<Vec3> ours;
  for (const Index v : refiner.boundary(kLevels).vertices) ours.push_back(limit.positions()[v]);
  expectSamePoints(surface.limit(), ours);
}

TEST(Loop, SmoothBoundaries) {
  expectLoop(testing::singleTetrahedron());
  expectLoop(testing::singleOctahedron());
  expectLoop(testing::tetrahedraAroundEdge(5));
  expectLoop(testing::tetrahedraAroundEdge(8));
}

TEST(Loop, CreasesAndCorners) {
  expectLoop(testing::creasedBox(1, 0, 1));
  expectLoop(testing::creasedBox(2, 0.1, 1));
}

TEST(Loop, OneClosedCreaseOnASmoothSurface) {
  ControlMeshInput mesh = testing::singleOctahedron();
  mesh.creases = {{1, 2}, {2, 3}, {3, 4}, {1, 4}};
  expectLoop(mesh);
}

}  // namespace
}  // namespace octet
