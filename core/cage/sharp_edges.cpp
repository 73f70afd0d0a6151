// SPDX-License-Identifier: Apache-2.0
#include "sharp_edges.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <tbb/parallel_sort.h>

#include "../base/disjoint_sets.h"
#include "../base/numbers.h"

namespace octet {
namespace {

/// A side of a triangle: sorted vertices, the triangle, and whether it runs from low to high.
struct Side {
  Index low, high, triangle;
  bool forward;

  bool operator<(const Side& o) const {
    return std::tie(low, high, triangle) < std::tie(o.low, o.high, o.triangle);
  }
  bool sameEdge(const Side& o) const { return low == o.low && high == o.high; }
};

class Finder {
 public:
  Finder(const TriangleSurface& surface, double angle, double leastLength)
      : s_(surface), leastCosine_(std::cos(angle * kPi / 180)), leastLength_(leastLength) {}

  SharpEdges run() {
    findEdges();
    if (leastLength_ > 0) dropShort();
    collectEnds();
    findCorners();
    joinChains();
    return std::move(out_);
  }

 private:
  Vec3 normal(Index t) const {
    const auto& [a, b, c] = s_.triangles[t];
    return (s_.vertices[b] - s_.vertices[a])
        .cross(s_.vertices[c] - s_.vertices[a])
        .stableNormalized();
  }

  bool turns(const Side& a, const Side& b) const {
    const double cosine = normal(a.triangle).dot(normal(b.triangle));
    return (a.forward == b.forward ? -cosine : cosine) < leastCosine_ &&
           normal(a.triangle) != Vec3::Zero() && normal(b.triangle) != Vec3::Zero();
  }

  void findEdges() {
    std::vector<Side> sides;
    sides.reserve(3 * s_.triangles.size());
    for (std::size_t t = 0; t < s_.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        const Index a = s_.triangles[t][k], b = s_.triangles[t][(k + 1) % 3];
        sides.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(t), a < b});
      }
    }
    tbb::parallel_sort(sides.begin(), sides.end());
    for (std::size_t k = 0, end; k < sides.size(); k = end) {
      end = k + 1;
      while (end < sides.size() && sides[k].sameEdge(sides[end])) ++end;
      if (end - k != 2 || turns(sides[k], sides[k + 1])) {
        out_.edges.push_back({sides[k].low, sides[k].high});
      }
    }
  }

  double length(const std::array<Index, 2>& edge) const {
    return (s_.vertices[edge[1]] - s_.vertices[edge[0]]).norm();
  }

  /// Drops what is connected and short.
  void dropShort() {
    DisjointSets roots(static_cast<Index>(s_.vertices.size()));
    for (const auto& [a, b] : out_.edges) roots.join(a, b);
    std::vector<double> lengths(s_.vertices.size(), 0.0);
    for (const auto& edge : out_.edges) lengths[roots.find(edge[0])] += length(edge);
    const auto isShort = [&](const auto& edge) {
      return lengths[roots.find(edge[0])] < leastLength_;
    };
    out_.edges.erase(std::remove_if(out_.edges.begin(), out_.edges.end(), isShort),
                     out_.edges.end());
  }

  /// Sharp edges at each vertex that has any.
  void collectEnds() {
    for (std::size_t e = 0; e < out_.edges.size(); ++e) {
      for (const Index v : out_.edges[e]) ends_.push_back({v, static_cast<Index>(e)});
    }
    std::sort(ends_.begin(), ends_.end());
    inChain_ = DisjointSets(static_cast<Index>(out_.edges.size()));
  }

  Vec3 direction(Index edge, Index from) const {
    const auto& [a, b] = out_.edges[edge];
    return (s_.vertices[from == a ? b : a] - s_.vertices[from]).normalized();
  }

  void findCorners() {
    for (std::size_t k = 0, end; k < ends_.size(); k = end) {
      end = k + 1;
      while (end < ends_.size() && ends_[end][0] == ends_[k][0]) ++end;
      const Index v = ends_[k][0], e = ends_[k][1], f = ends_[end - 1][1];
      if (end - k == 2 && -direction(e, v).dot(direction(f, v)) >= leastCosine_) {
        inChain_.join(e, f);
      } else {
        out_.corners.push_back(v);
      }
    }
  }

  void joinChains() {
    std::vector<Index> number(out_.edges.size(), kNone);
    for (std::size_t e = 0; e < out_.edges.size(); ++e) {
      Index& n = number[inChain_.find(static_cast<Index>(e))];
      if (n == kNone) n = out_.chainCount++;
      out_.chains.push_back(n);
    }
  }

  const TriangleSurface& s_;
  const double leastCosine_, leastLength_;
  SharpEdges out_;
  std::vector<std::array<Index, 2>> ends_;  // vertex, edge
  DisjointSets inChain_{0};                 // of edges
};

}  // namespace

SharpEdges findSharpEdges(const TriangleSurface& surface, double angle, double leastLength) {
  return Finder(surface, angle, leastLength).run();
}

std::vector<TriangleSurface> chainsAsSurfaces(const TriangleSurface& surface,
                                              const SharpEdges& sharp) {
  std::vector<TriangleSurface> chains(sharp.chainCount);
  for (std::size_t e = 0; e < sharp.edges.size(); ++e) {
    TriangleSurface& chain = chains[sharp.chains[e]];
    const Index n = static_cast<Index>(chain.vertices.size());
    for (const Index v : sharp.edges[e]) chain.vertices.push_back(surface.vertices[v]);
    chain.triangles.push_back({n, n + 1, n + 1});
  }
  return chains;
}

}  // namespace octet
