// SPDX-License-Identifier: Apache-2.0
#include "boundary_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <queue>

namespace octet {
namespace {

/// Vertices are nearer than this, in spacings, to the corner or chain that they go to. A fitted
/// lattice comes as near as 0.5 to 1.2 to the edges of a cube, and as 0.7 to 1.5 to its corners.
constexpr double kReach = 1.6;
/// Distance from the chain, in spacings, that doubles the cost of an edge.
constexpr double kDear = 0.2;

/// A piece of a chain between two points that paths begin and end at.
struct Piece {
  Index chain = kNone;
  std::vector<Vec3> points;
  Index start = kNone, end = kNone;  ///< the cage's vertices there
};

class Finder {
 public:
  Finder(const Complex& complex, const Array<Vec3>& positions, const TriangleSurface& surface,
         const SharpEdges& sharp, double spacing)
      : c_(complex), x_(positions), s_(surface), sharp_(sharp), spacing_(spacing) {
    out_.corners.assign(c_.vertexCount(), kNone);
    out_.chains.assign(c_.vertexCount(), kNone);
    around_.resize(c_.vertexCount());
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      if (!c_.edgeOnBoundary(e)) continue;
      const auto& [a, b] = c_.edges[e];
      around_[a].push_back(b);
      around_[b].push_back(a);
    }
  }

  BoundaryFeatures run() {
    placeCorners();
    std::vector<std::vector<Index>> edges(sharp_.chainCount);
    for (std::size_t e = 0; e < sharp_.edges.size(); ++e) {
      edges[sharp_.chains[e]].push_back(static_cast<Index>(e));
    }
    for (Index chain = 0; chain < sharp_.chainCount; ++chain) {
      for (const Piece& piece : pieces(chain, edges[chain])) follow(piece);
    }
    std::sort(out_.edges.begin(), out_.edges.end());
    return std::move(out_);
  }

 private:
  bool isFree(Index v) const { return out_.corners[v] == kNone && out_.chains[v] == kNone; }

  /// The boundary vertex nearest to a point that has no place yet.
  Index nearestVertex(const Vec3& p) const {
    Index best = kNone;
    double least = kReach * spacing_;
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      if (around_[v].empty() || !isFree(v)) continue;
      const double distance = (x_[v] - p).norm();
      if (distance >= least) continue;
      least = distance;
      best = v;
    }
    return best;
  }

  void placeCorners() {
    for (const Index corner : sharp_.corners) {
      const Index v = nearestVertex(s_.vertices[corner]);
      if (v == kNone) continue;
      out_.corners[v] = corner;
      vertexAt_[corner] = v;
    }
  }

  /// The vertices of a chain in order; the first again at the end when it runs around.
  std::vector<Index> inOrder(const std::vector<Index>& edges) const {
    std::map<Index, std::vector<Index>> next;
    for (const Index e : edges) {
      const auto& [a, b] = sharp_.edges[e];
      next[a].push_back(b);
      next[b].push_back(a);
    }
    const auto isCorner = [&](Index v) {
      return std::binary_search(sharp_.corners.begin(), sharp_.corners.end(), v);
    };
    auto first = std::find_if(next.begin(), next.end(),
                              [&](const auto& entry) { return isCorner(entry.first); });
    if (first == next.end()) first = next.begin();
    std::vector<Index> order = {first->first};
    for (Index from = kNone, at = first->first;;) {
      const std::vector<Index>& ends = next.at(at);
      const Index to = ends[0] == from && ends.size() > 1 ? ends[1] : ends[0];
      order.push_back(to);
      from = at;
      at = to;
      if (isCorner(at) || at == order[0]) return order;
    }
  }

  /// A chain between two corners; one that runs around is cut in three.
  std::vector<Piece> pieces(Index chain, const std::vector<Index>& edges) {
    const std::vector<Index> order = inOrder(edges);
    Piece whole;
    whole.chain = chain;
    for (const Index v : order) whole.points.push_back(s_.vertices[v]);
    if (order.front() != order.back()) {
      whole.start = at(order.front());
      whole.end = at(order.back());
      return {whole};
    }
    constexpr std::size_t kCuts = 3;
    std::vector<Piece> cut(kCuts);
    const std::size_t n = order.size() - 1;
    if (n < kCuts) return {};
    Index starts[kCuts];
    for (std::size_t k = 0; k < kCuts; ++k) {
      const Index v = order[k * n / kCuts];
      starts[k] = at(v) != kNone ? at(v) : nearestVertex(s_.vertices[v]);
      if (starts[k] == kNone) return {};
      if (out_.corners[starts[k]] == kNone) out_.chains[starts[k]] = chain;
    }
    for (std::size_t k = 0; k < kCuts; ++k) {
      const std::size_t from = k * n / kCuts, to = (k + 1) * n / kCuts;
      cut[k].chain = chain;
      cut[k].points.assign(whole.points.begin() + static_cast<std::ptrdiff_t>(from),
                           whole.points.begin() + static_cast<std::ptrdiff_t>(to) + 1);
      cut[k].start = starts[k];
      cut[k].end = starts[(k + 1) % kCuts];
    }
    return cut;
  }

  Index at(Index corner) const {
    const auto found = vertexAt_.find(corner);
    return found == vertexAt_.end() ? kNone : found->second;
  }

  void follow(const Piece& piece) {
    if (piece.start == kNone || piece.end == kNone) return;
    const std::vector<Index> path = shortestPath(piece);
    for (std::size_t k = 1; k < path.size(); ++k) {
      if (k + 1 < path.size()) out_.chains[path[k]] = piece.chain;
      out_.edges.push_back({std::min(path[k - 1], path[k]), std::max(path[k - 1], path[k])});
    }
  }

  /// Dijkstra's, over boundary edges near the piece; edges far from it are dear.
  std::vector<Index> shortestPath(const Piece& piece) const {
    TriangleSurface line;
    line.vertices.assign(piece.points.begin(), piece.points.end());
    for (Index k = 1; k < static_cast<Index>(piece.points.size()); ++k) {
      line.triangles.push_back({k - 1, k, k});
    }
    const ClosestPoints closest(line);
    std::map<Index, double> cost = {{piece.start, 0}};
    std::map<Index, Index> before;
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    open.emplace(0, piece.start);
    while (!open.empty()) {
      const auto [so_far, v] = open.top();
      open.pop();
      if (v == piece.end) break;
      if (so_far > cost[v]) continue;
      for (const Index u : around_[v]) {
        if (u != piece.end && !isFree(u)) continue;
        const double distance = closest.find(x_[u]).distance / spacing_;
        if (distance > kReach) continue;
        const double middle = closest.find((x_[u] + x_[v]) / 2).distance / spacing_;
        const double far = (distance + middle) / kDear;
        const double total = so_far + (x_[u] - x_[v]).norm() * (1 + far * far);
        const auto known = cost.find(u);
        if (known != cost.end() && known->second <= total) continue;
        cost[u] = total;
        before[u] = v;
        open.emplace(total, u);
      }
    }
    if (before.find(piece.end) == before.end()) return {};
    std::vector<Index> path = {piece.end};
    while (path.back() != piece.start) path.push_back(before.at(path.back()));
    std::reverse(path.begin(), path.end());
    return withoutDetours(path);
  }

  /// No two edges of one facet: what is joined by an edge follows directly.
  std::vector<Index> withoutDetours(const std::vector<Index>& path) const {
    std::vector<Index> direct = {path[0]};
    for (std::size_t k = 0; k + 1 < path.size();) {
      std::size_t next = k + 1;
      for (std::size_t l = k + 2; l < path.size(); ++l) {
        const auto& around = around_[path[k]];
        if (std::count(around.begin(), around.end(), path[l]) > 0) next = l;
      }
      direct.push_back(path[next]);
      k = next;
    }
    return direct;
  }

  const Complex& c_;
  const Array<Vec3>& x_;
  const TriangleSurface& s_;
  const SharpEdges& sharp_;
  const double spacing_;
  BoundaryFeatures out_;
  std::vector<std::vector<Index>> around_;  // neighbours along boundary edges
  std::map<Index, Index> vertexAt_;         // by the surface's corner
};

}  // namespace

BoundaryFeatures findBoundaryFeatures(const Complex& complex, const Array<Vec3>& positions,
                                      const TriangleSurface& surface, const SharpEdges& sharp,
                                      double spacing) {
  return Finder(complex, positions, surface, sharp, spacing).run();
}

}  // namespace octet
