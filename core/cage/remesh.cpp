// SPDX-License-Identifier: Apache-2.0
#include "remesh.h"

#include <algorithm>
#include <cmath>
#include <queue>

#include "half_edges.h"

namespace octet {
namespace {

/// Edges longer than this times the wanted length are split, shorter ones collapsed: so that a
/// split makes none to collapse, and a collapse none to split (Botsch and Kobbelt). The median
/// length is some 0.93 of the wanted one.
constexpr double kLong = 4.0 / 3, kShort = 4.0 / 5;
constexpr int kRounds = 10;
/// Least cosines of the angle by which normals may turn when an edge is collapsed or turned, or a
/// vertex moved.
constexpr double kCollapseTurn = 0.6, kFlipTurn = 0.8, kMoveTurn = 0.5;
/// Farthest that a collapse may take a triangle's centroid from the surface, in wanted lengths.
constexpr double kDeviation = 0.2;
/// Neighbours of a vertex in the triangular lattice.
constexpr int kRegularValence = 6;

/// Triangles less high than this times their longest edge are slivers.
constexpr double kSliver = 1e-6;

enum class Kind : std::uint8_t { Smooth, Crease, Corner };

class Remesher {
 public:
  Remesher(const TriangleSurface& surface, const RemeshOptions& options)
      : options_(options),
        sharp_(findSharpEdges(surface, options.sharpAngle, kLeastSharp * options.edgeLength)),
        mesh_(surface, sharp_),
        x_(surface.vertices.begin(), surface.vertices.end()),
        given_(turned()),
        closest_(given_),
        chains_(chainsAsSurfaces(surface, sharp_)),
        closestOnChain_(chains_.begin(), chains_.end()) {
    kinds_.assign(x_.size(), Kind::Smooth);
    for (const auto& edge : sharp_.edges) {
      for (const Index v : edge) kinds_[v] = Kind::Crease;
    }
    for (const Index v : sharp_.corners) kinds_[v] = Kind::Corner;
  }

  RemeshedSurface run() {
    for (int round = 0; round < kRounds; ++round) {
      reportProgress(options_.progress, {"remesh surface", static_cast<std::size_t>(round),
                                         static_cast<std::size_t>(kRounds), "rounds"});
      splitLong();
      collapseShort();
      flipAll([&](Index h) { return improvesValences(h); });
      flipAll([&](Index h) { return improvesAngles(h); });
      relax();
    }
    flipAll([&](Index h) { return improvesAngles(h); });
    return result();
  }

 private:
  /// The surface given, with triangles that agree with their neighbours.
  TriangleSurface turned() const {
    std::vector<std::array<Index, 2>> ignored;
    return mesh_.surface(x_, &ignored);
  }

  // ---- measures ---------------------------------------------------------------------------------

  double length(Index h) const { return (x_[mesh_.to(h)] - x_[mesh_.from(h)]).norm(); }

  static Vec3 areaVector(const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b - a).cross(c - a);
  }
  Vec3 areaVector(Index a, Index b, Index c) const { return areaVector(x_[a], x_[b], x_[c]); }
  Vec3 areaVector(Index h) const { return areaVector(mesh_.from(h), mesh_.to(h), mesh_.apex(h)); }

  static double cosine(const Vec3& m, const Vec3& n) {
    const double norms = m.norm() * n.norm();
    return norms > 0 ? m.dot(n) / norms : 1;  // what has no area has any normal
  }

  /// Cotangent of the angle across from a half-edge, at `apex`.
  static double cotangent(const Vec3& apex, const Vec3& a, const Vec3& b) {
    return (a - apex).dot(b - apex) / std::max((a - apex).cross(b - apex).norm(), 1e-300);
  }

  /// The nearest point of the chain that a half-edge is on, or of the surface.
  Vec3 project(const Vec3& p, Index chain) const {
    return chain == kNone ? closest_.find(p).position : closestOnChain_[chain].find(p).position;
  }

  // ---- splits and collapses ---------------------------------------------------------------------

  using Queue = std::priority_queue<std::pair<double, Index>>;

  void splitLong() {
    const double most = kLong * options_.edgeLength;
    Queue queue;
    const auto add = [&](Index h) {
      if (length(h) > most) queue.emplace(length(h), std::min(h, mesh_.twin(h)));
    };
    for (Index h = 0; h < mesh_.count(); ++h) {
      if (mesh_.alive(h) && h < mesh_.twin(h)) add(h);
    }
    while (!queue.empty()) {
      const auto [l, h] = queue.top();
      queue.pop();
      if (length(h) != l) continue;
      const Index chain = mesh_.chain(h);
      x_.push_back(project((x_[mesh_.from(h)] + x_[mesh_.to(h)]) / 2, chain));
      kinds_.push_back(chain == kNone ? Kind::Smooth : Kind::Crease);
      // The sides around have new numbers.
      mesh_.visitRing(mesh_.split(h), [&](Index k) {
        add(k);
        add(mesh_.next(k));
      });
    }
  }

  void collapseShort() {
    const double least = kShort * options_.edgeLength;
    Queue queue;
    const auto add = [&](Index h) {
      if (length(h) < least) queue.emplace(-length(h), std::min(h, mesh_.twin(h)));
    };
    for (Index h = 0; h < mesh_.count(); ++h) {
      if (mesh_.alive(h) && h < mesh_.twin(h)) add(h);
    }
    while (!queue.empty()) {
      const auto [l, h] = queue.top();
      queue.pop();
      if (!mesh_.alive(h) || length(h) != -l) continue;
      for (const Index k : {h, mesh_.twin(h)}) {
        if (!mayCollapse(k)) continue;
        const Index kept = mesh_.to(k);
        mesh_.collapse(k);
        mesh_.visitRing(kept, add);
        break;
      }
    }
  }

  /// May from(h) be merged into to(h)?
  bool mayCollapse(Index h) const {
    const Index a = mesh_.from(h), b = mesh_.to(h);
    if (kinds_[a] == Kind::Corner) return false;
    if (kinds_[a] == Kind::Crease && mesh_.chain(h) == kNone) return false;
    if (!mesh_.canCollapse(h)) return false;
    bool may = true;
    mesh_.visitRing(a, [&](Index k) {
      const Index c = mesh_.to(k), d = mesh_.apex(k);
      may = may && (c == b || (x_[c] - x_[b]).norm() <= kLong * options_.edgeLength);
      if (!may || c == b || d == b) return;
      const Vec3 area = areaVector(b, c, d);
      const Vec3 centre = (x_[b] + x_[c] + x_[d]) / 3;
      may = area != Vec3::Zero() && cosine(area, areaVector(k)) >= kCollapseTurn &&
            closest_.find(centre).distance <= kDeviation * options_.edgeLength;
    });
    return may;
  }

  // ---- flips ------------------------------------------------------------------------------------

  template <typename Improves>
  void flipAll(const Improves& improves) {
    constexpr int kSweeps = 5;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      bool any = false;
      for (Index h = 0; h < mesh_.count(); ++h) {
        if (!mesh_.alive(h) || h > mesh_.twin(h) || mesh_.chain(h) != kNone) continue;
        if (!improves(h) || !mayFlip(h)) continue;
        mesh_.flip(h);
        any = true;
      }
      if (!any) break;
    }
  }

  bool mayFlip(Index h) const {
    const Index g = mesh_.twin(h);
    const Index a = mesh_.from(h), b = mesh_.to(h), c = mesh_.apex(h), d = mesh_.apex(g);
    const Vec3 before = areaVector(h) + areaVector(g);
    const Vec3 left = areaVector(a, d, c), right = areaVector(d, b, c);
    if (left == Vec3::Zero() || right == Vec3::Zero()) return false;
    const double bend = std::min(cosine(areaVector(h), areaVector(g)), kFlipTurn);
    return cosine(left, before) >= kFlipTurn && cosine(right, before) >= kFlipTurn &&
           cosine(left, right) >= bend && mesh_.canFlip(h);
  }

  /// How much the squares of the vertices' deviations from the regular valence shrink.
  bool improvesValences(Index h) const {
    const Index ends[4] = {mesh_.from(h), mesh_.to(h), mesh_.apex(h), mesh_.apex(mesh_.twin(h))};
    Index gain = 0;
    for (int k = 0; k < 4; ++k) {
      if (kinds_[ends[k]] == Kind::Corner) continue;
      const Index excess = mesh_.valence(ends[k]) - kRegularValence;
      gain += k < 2 ? 2 * excess - 1 : -2 * excess - 1;
    }
    return gain > 0;
  }

  /// Is the edge not Delaunay: do the angles across from it sum up to more than 180 degrees?
  bool improvesAngles(Index h) const {
    const Vec3 &a = x_[mesh_.from(h)], &b = x_[mesh_.to(h)];
    const Index c = mesh_.apex(h), d = mesh_.apex(mesh_.twin(h));
    return cotangent(x_[c], a, b) + cotangent(x_[d], a, b) < -1e-9;
  }

  // ---- moves ------------------------------------------------------------------------------------

  void relax() {
    for (Index v = 0; v < mesh_.vertexCount(); ++v) {
      if (!mesh_.hasVertex(v) || kinds_[v] == Kind::Corner) continue;
      const Vec3 from = x_[v];
      Index chain = kNone;
      const Vec3 step = relaxingStep(v, &chain);
      for (const double part : {1.0, 0.5, 0.25}) {
        if (tryMove(v, project(from + part * step, chain))) break;
      }
    }
  }

  /// Towards the mean of the neighbours, along the surface; on a chain, of the two neighbours
  /// there.
  Vec3 relaxingStep(Index v, Index* chain) const {
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    int n = 0;
    mesh_.visitRing(v, [&](Index h) {
      normal += areaVector(h);
      if (kinds_[v] == Kind::Crease && mesh_.chain(h) == kNone) return;
      *chain = mesh_.chain(h);
      sum += x_[mesh_.to(h)];
      ++n;
    });
    const Vec3 step = sum / n - x_[v];
    if (kinds_[v] == Kind::Crease) return step;
    normal.stableNormalize();
    return step - step.dot(normal) * normal;
  }

  /// Moves a vertex unless that turns a triangle too far.
  bool tryMove(Index v, const Vec3& to) {
    bool may = true;
    mesh_.visitRing(v, [&](Index h) {
      const Vec3 area = areaVector(to, x_[mesh_.to(h)], x_[mesh_.apex(h)]);
      may = may && area != Vec3::Zero() && cosine(area, areaVector(h)) >= kMoveTurn;
    });
    if (may) x_[v] = to;
    return may;
  }

  RemeshedSurface result() const {
    RemeshedSurface result;
    result.surface = mesh_.surface(x_, &result.creases);
    Index number = 0;
    for (Index v = 0; v < mesh_.vertexCount(); ++v) {
      if (!mesh_.hasVertex(v)) continue;
      if (kinds_[v] == Kind::Corner) result.corners.push_back(number);
      ++number;
    }
    return result;
  }

  const RemeshOptions& options_;
  const SharpEdges sharp_;
  HalfEdges mesh_;
  std::vector<Vec3> x_;
  const TriangleSurface given_;
  const ClosestPoints closest_;
  const std::vector<TriangleSurface> chains_;
  const std::vector<ClosestPoints> closestOnChain_;
  std::vector<Kind> kinds_;
};

}  // namespace

RemeshedSurface remesh(const TriangleSurface& surface, const RemeshOptions& options) {
  return Remesher(surface, options).run();
}

TriangleSurface withoutSlivers(const TriangleSurface& surface) {
  constexpr int kSweeps = 10;
  HalfEdges mesh(surface, {});
  const std::vector<Vec3> x(surface.vertices.begin(), surface.vertices.end());
  const auto vector = [&](Index h) -> Vec3 { return x[mesh.to(h)] - x[mesh.from(h)]; };
  bool any = true;
  for (int sweep = 0; any && sweep < kSweeps; ++sweep) {
    any = false;
    for (Index t = 0; t < mesh.count(); t += 3) {
      if (!mesh.alive(t)) continue;
      const auto shorter = [&](Index h, Index g) { return vector(h).norm() < vector(g).norm(); };
      const Index sides[3] = {t, t + 1, t + 2};
      const Index longest = *std::max_element(sides, sides + 3, shorter);
      const Index shortest = *std::min_element(sides, sides + 3, shorter);
      const double length = vector(longest).norm();
      const double area = vector(longest).cross(vector(mesh.next(longest))).norm();
      if (area >= kSliver * length * length) continue;
      if (vector(shortest).norm() < kSliver * length) {
        if (!mesh.canCollapse(shortest)) continue;
        mesh.collapse(shortest);
      } else {
        if (!mesh.canFlip(longest)) continue;
        mesh.flip(longest);
      }
      any = true;
    }
  }
  std::vector<std::array<Index, 2>> ignored;
  return mesh.surface(x, &ignored);
}

}  // namespace octet
