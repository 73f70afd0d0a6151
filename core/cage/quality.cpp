// SPDX-License-Identifier: Apache-2.0
#include "quality.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "../base/disjoint_sets.h"
#include "../base/numbers.h"
#include "../topology/boundary.h"
#include "../topology/control_mesh.h"

namespace octet {
namespace {

constexpr double kDegrees = 180 / kPi;

struct Extremes {
  double minDihedral = HUGE_VAL, maxDihedral = -HUGE_VAL;
  double minVolume = HUGE_VAL, maxVolume = 0, minShape = HUGE_VAL;

  void join(const Extremes& o) {
    minDihedral = std::min(minDihedral, o.minDihedral);
    maxDihedral = std::max(maxDihedral, o.maxDihedral);
    minVolume = std::min(minVolume, o.minVolume);
    maxVolume = std::max(maxVolume, o.maxVolume);
    minShape = std::min(minShape, o.minShape);
  }
};

template <typename Shape>
void measureCell(const Vec3* p, double volume6, Extremes* e) {
  double longest = 0;
  for (const auto& [i, j] : Shape::edges) longest = std::max(longest, (p[i] - p[j]).norm());
  // Regular cells with edges of length 1: a tetrahedron sqrt(2)/12, an octahedron sqrt(2)/3.
  const double regular6 = Shape::kVertices == 4 ? std::sqrt(2.0) / 2 : 2 * std::sqrt(2.0);
  const double size = std::abs(volume6);
  e->minVolume = std::min(e->minVolume, size / 6);
  e->maxVolume = std::max(e->maxVolume, size / 6);
  e->minShape = std::min(e->minShape, size / (regular6 * longest * longest * longest));
  Vec3 normals[Shape::kFacets];
  for (int f = 0; f < Shape::kFacets; ++f) {
    const auto& t = Shape::facets[f];
    normals[f] = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) * (volume6 < 0 ? -1 : 1);
  }
  for (int k = 0; k < Shape::kEdges; ++k) {
    const EdgeInFacet* at = kCellTables<Shape>.edgeFacets[k];
    // Facet 0's boundary runs along the edge in the direction that `sign` tells; a reflex angle
    // shows in the normals' turn about it.
    const Vec3 along = (p[Shape::edges[k][1]] - p[Shape::edges[k][0]]).normalized() * at[0].sign *
                       (volume6 < 0 ? -1 : 1);
    const Vec3 &a = normals[at[0].facet], &b = normals[at[1].facet];
    const double turn = std::atan2(a.cross(b).dot(along), a.dot(b));
    const double dihedral = 180 - turn * kDegrees;
    e->minDihedral = std::min(e->minDihedral, dihedral);
    e->maxDihedral = std::max(e->maxDihedral, dihedral);
  }
}

Extremes measureCells(const Complex& c, const Array<Vec3>& x) {
  return tbb::parallel_reduce(
      tbb::blocked_range<Index>(0, c.cellCount(), 1024), Extremes{},
      [&](const tbb::blocked_range<Index>& range, Extremes e) {
        for (Index cell = range.begin(); cell != range.end(); ++cell) {
          Vec3 p[6];
          for (int i = 0; i < c.cellVertexCount(cell); ++i) p[i] = x[c.cellVertex(cell, i)];
          const double volume6 = cellVolume6(c, x, cell);
          if (c.isTet(cell)) {
            measureCell<Tetrahedron>(p, volume6, &e);
          } else {
            measureCell<Octahedron>(p, volume6, &e);
          }
        }
        return e;
      },
      [](Extremes a, const Extremes& b) {
        a.join(b);
        return a;
      });
}

Index countComponents(const Complex& c) {
  DisjointSets parts(c.cellCount());
  for (const auto& [a, b] : c.facetCells) {
    if (a.exists() && b.exists()) parts.join(a.cell(), b.cell());
  }
  return parts.count();
}

/// Boundary edges with more than two boundary facets.
Index countTouchingEdges(const Complex& c) {
  Array<std::uint8_t> facets;
  facets.assign(c.edgeCount(), 0);
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (!c.facetOnBoundary(f)) continue;
    for (const EdgeRef& e : c.facetEdges[f]) facets[e.index()] += facets[e.index()] < 3;
  }
  return static_cast<Index>(std::count(facets.begin(), facets.end(), 3));
}

/// Boundary vertices whose boundary facets, joined across edges, are not one ring.
Index countTouchingVertices(const Complex& c) {
  // Each boundary facet has three corners; corners at a vertex are joined across the edges there.
  struct Corner {
    Index edge, vertex, corner;
  };
  std::vector<Index> vertexOf;
  std::vector<Corner> atEdges;
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (!c.facetOnBoundary(f)) continue;
    const auto v = c.facetVertices(f);
    const Index first = static_cast<Index>(vertexOf.size());
    for (int k = 0; k < 3; ++k) {
      vertexOf.push_back(v[k]);
      atEdges.push_back({c.facetEdge(f, k, (k + 1) % 3).index(), v[k], first + k});
      atEdges.push_back({c.facetEdge(f, k, (k + 2) % 3).index(), v[k], first + k});
    }
  }
  std::sort(atEdges.begin(), atEdges.end(), [](const Corner& a, const Corner& b) {
    return std::tie(a.edge, a.vertex, a.corner) < std::tie(b.edge, b.vertex, b.corner);
  });
  DisjointSets parts(static_cast<Index>(vertexOf.size()));
  for (std::size_t k = 0; k + 1 < atEdges.size(); ++k) {
    const Corner &a = atEdges[k], &b = atEdges[k + 1];
    if (a.edge == b.edge && a.vertex == b.vertex) parts.join(a.corner, b.corner);
  }
  Array<std::uint8_t> rings;
  rings.assign(c.vertexCount(), 0);
  for (Index k = 0; k < static_cast<Index>(vertexOf.size()); ++k) {
    if (parts.find(k) == k) rings[vertexOf[k]] += rings[vertexOf[k]] < 2;
  }
  return static_cast<Index>(std::count(rings.begin(), rings.end(), 2));
}

}  // namespace

CageQuality measureQuality(const Complex& complex, const Array<Vec3>& positions) {
  const Extremes e = measureCells(complex, positions);
  CageQuality quality;
  quality.minDihedral = e.minDihedral;
  quality.maxDihedral = e.maxDihedral;
  quality.minVolume = e.minVolume;
  quality.maxVolume = e.maxVolume;
  quality.minShape = e.minShape;
  quality.components = countComponents(complex);
  quality.touchingEdges = countTouchingEdges(complex);
  quality.touchingVertices = countTouchingVertices(complex);
  return quality;
}

}  // namespace octet
