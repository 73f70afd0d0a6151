// SPDX-License-Identifier: Apache-2.0
#include "boundary_fit.h"

#include <algorithm>
#include <cmath>

#include "../base/error.h"
#include "../base/reported_loop.h"
#include "cell_shape.h"

namespace octet {
namespace {

/// Vertices nearer to the surface than this times the mean edge count as on it.
constexpr double kOnSurface = 1e-3;
/// Halvings of a step before it is given up.
constexpr int kHalvings = 5;
/// A push towards the surface may not distort the cells at a vertex beyond this, per corner on
/// average; sliding then makes room.
constexpr double kMostDistorted = 40;
/// Least cosine between the normals of neighbouring boundary facets; in a filled lattice they have
/// -1/3. Positive cells can still wrap around an edge by more than a full turn.
constexpr double kMostFolded = -0.7;
/// A vertex rests while neither it nor one it shares a cell with moves farther, in mean edges.
constexpr double kRest = 1e-3;

class Fitter {
 public:
  Fitter(const ControlMesh& mesh, Array<Vec3> start, const ProjectToSurface& project,
         const BoundaryFitOptions& options, const Context& context)
      : c_(*mesh.complex()),
        x_(std::move(start)),
        project_(project),
        options_(options),
        context_(context) {
    if (options.rounds < 0 || !(options.minVolume > 0 && options.minVolume < 1)) {
      throw InputError("fit", "rounds or least volume out of range");
    }
    measureCells(mesh.positions());
    joinFacets();
    chooseMovable();
    colour();
    awake_.assign(c_.vertexCount(), 1);
  }

  Array<Vec3> run(BoundaryFitReport* report) {
    BoundaryFitReport r;
    vertexDistances(&r.meanBefore, &r.maxBefore, nullptr);
    for (int round = 0; round < options_.rounds; ++round) {
      context_.report({"fit boundary", static_cast<std::size_t>(round),
                       static_cast<std::size_t>(options_.rounds), "rounds"});
      for (const std::vector<Index>& group : groups_) {
        parallelFor<std::size_t>(
            group.size(),
            [&](std::size_t k) {
              if (awake_[group[k]]) move(group[k]);
            },
            context_, 64);
      }
      if (!wake()) break;
    }
    vertexDistances(&r.meanAfter, &r.maxAfter, &r.offSurface);
    facetDistances(&r);
    r.minVolume = HUGE_VAL;
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      r.minVolume = std::min(r.minVolume, measureShape(c_, x_, cell).minVolume6 / reference(cell));
    }
    if (report) *report = r;
    return std::move(x_);
  }

 private:
  void measureCells(const Array<Vec3>& x) {
    double sum = 0;
    for (const auto& [a, b] : c_.edges) sum += (x[b] - x[a]).norm();
    edge_ = sum / c_.edgeCount();
    double tets = 0, octs = 0;
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      (c_.isTet(cell) ? tets : octs) += std::abs(cellVolume6(c_, x, cell));
    }
    tetCorner_ = c_.tetCount() ? tets / c_.tetCount() : 0;
    octCorner_ = c_.octCount() ? octs / c_.octCount() / 8 : 0;
  }

  /// Average of six times the volume of a corner of a cell of its kind, before.
  double reference(Index cell) const { return c_.isTet(cell) ? tetCorner_ : octCorner_; }

  /// The two boundary facets of each boundary edge, and the boundary facets of each vertex.
  void joinFacets() {
    edgeFacets_.assign(c_.edgeCount(), {kNone, kNone});
    facetBegin_.assign(c_.vertexCount() + 1, 0);
    std::vector<std::array<Index, 2>> pairs;
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      for (const EdgeRef& e : c_.facetEdges[f]) {
        auto& pair = edgeFacets_[e.index()];
        pair[pair[0] == kNone ? 0 : 1] = f;
      }
      for (const Index v : c_.facetVertices(f)) pairs.push_back({v, f});
    }
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [v, f] : pairs) {
      ++facetBegin_[v + 1];
      vertexFacets_.push_back(f);
    }
    for (Index v = 0; v < c_.vertexCount(); ++v) facetBegin_[v + 1] += facetBegin_[v];
  }

  /// Layers of vertices below the boundary, layer 0.
  void chooseMovable() {
    std::vector<std::uint8_t> movable(c_.vertexCount(), 0);
    std::vector<Index> layer;
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      if (!c_.vertexOnBoundary(v)) continue;
      movable[v] = 1;
      layer.push_back(v);
    }
    movable_ = layer;
    for (int depth = 0; depth < options_.interiorLayers; ++depth) {
      std::vector<Index> next;
      for (const Index v : layer) {
        visitNeighbours(v, [&](Index u) {
          if (movable[u]) return;
          movable[u] = 1;
          next.push_back(u);
        });
      }
      std::sort(next.begin(), next.end());
      movable_.insert(movable_.end(), next.begin(), next.end());
      layer = std::move(next);
    }
  }

  template <typename Visit>
  void visitNeighbours(Index v, const Visit& visit) const {
    c_.visitVertexStar(v, [&](const CellAtVertex& at) {
      for (int i = 0; i < c_.cellVertexCount(at.cell); ++i) visit(c_.cellVertex(at.cell, i));
    });
  }

  /// Groups of vertices no two of which share a cell, so that each may move in parallel.
  void colour() {
    std::vector<int> colours(c_.vertexCount(), -1);
    std::vector<Index> usedBy;
    for (const Index v : movable_) {
      visitNeighbours(v, [&](Index u) {
        if (colours[u] >= 0) usedBy[static_cast<std::size_t>(colours[u])] = v;
      });
      std::size_t colour = 0;
      while (colour < usedBy.size() && usedBy[colour] == v) ++colour;
      if (colour == usedBy.size()) {
        usedBy.push_back(kNone);
        groups_.emplace_back();
      }
      colours[v] = static_cast<int>(colour);
      groups_[colour].push_back(v);
    }
  }

  // ---- moves ------------------------------------------------------------------------------------

  /// Distortion and its gradient over the cells at a vertex; infinite where a corner is too small.
  struct Star {
    double distortion = 0;
    int corners = 0;
    Vec3 gradient = Vec3::Zero();
  };

  Star star(Index v, bool derive) const {
    Star s;
    c_.visitVertexStar(v, [&](const CellAtVertex& at) {
      const CellShape shape = measureShape(c_, x_, at.cell, derive ? at.place : -1);
      if (shape.minVolume6 < options_.minVolume * reference(at.cell)) s.distortion = HUGE_VAL;
      s.distortion += shape.distortion;
      s.gradient += shape.gradient;
      s.corners += c_.isTet(at.cell) ? 1 : 8;
    });
    if (folded(v)) s.distortion = HUGE_VAL;
    return s;
  }

  Vec3 outwardNormal(Index f) const {
    const auto [a, b, c] = c_.facetVertices(f);
    const Vec3 normal = (x_[b] - x_[a]).cross(x_[c] - x_[a]).normalized();
    return c_.facetCells[f][0].exists() ? normal : Vec3(-normal);
  }

  /// Is the boundary folded at an edge of the facets at a vertex?
  bool folded(Index v) const {
    for (Index k = facetBegin_[v]; k < facetBegin_[v + 1]; ++k) {
      const Index f = vertexFacets_[k];
      const Vec3 normal = outwardNormal(f);
      for (const EdgeRef& e : c_.facetEdges[f]) {
        const auto& [g, h] = edgeFacets_[e.index()];
        if (normal.dot(outwardNormal(g == f ? h : g)) < kMostFolded) return true;
      }
    }
    return false;
  }

  void move(Index v) {
    const Vec3 before = x_[v];
    const bool onBoundary = c_.vertexOnBoundary(v);
    const bool onSurface = onBoundary && push(v);
    slide(v, onBoundary, onSurface);
    awake_[v] = (x_[v] - before).norm() > kRest * edge_ || (onBoundary && !onSurface) ? 2 : 1;
  }

  /// Wakes the vertices that moved in this round and those around them; false when all rest.
  bool wake() {
    std::vector<std::uint8_t> next(awake_.size(), 0);
    bool any = false;
    for (const Index v : movable_) {
      if (awake_[v] != 2) continue;
      any = true;
      visitNeighbours(v, [&](Index u) { next[u] = 1; });
    }
    awake_ = std::move(next);
    return any;
  }

  /// As far towards the surface as the cells allow; is the vertex there then?
  bool push(Index v) {
    const Vec3 from = x_[v], to = project_(from, v);
    const double distance = (to - from).norm();
    if (distance <= 1e-12 * edge_) return true;
    double step = 1;
    for (int k = 0; k <= kHalvings; ++k, step /= 2) {
      x_[v] = k == 0 ? to : Vec3(from + step * (to - from));
      const Star s = star(v, false);
      if (s.distortion <= kMostDistorted * s.corners) return k == 0;
    }
    x_[v] = from;
    return distance <= kOnSurface * edge_;
  }

  /// Down the gradient of the distortion; along the surface for a vertex that is on it.
  void slide(Index v, bool onBoundary, bool onSurface) {
    const Star before = star(v, true);
    if (!std::isfinite(before.distortion)) return;
    const Vec3 from = x_[v];
    Vec3 along = -before.gradient;
    if (onBoundary && !onSurface) {
      const Vec3 normal = (project_(from, v) - from).normalized();
      along -= along.dot(normal) * normal;
    }
    const double slope = along.norm();
    if (!(slope > 0)) return;
    // f^2 of a corner has a second derivative of some 4 / edge^2 near regular.
    double step = edge_ * edge_ / (4.0 * before.corners);
    step = std::min(step, 0.25 * edge_ / slope);
    for (int k = 0; k <= kHalvings; ++k, step /= 2) {
      const Vec3 to = from + step * along;
      x_[v] = onSurface ? project_(to, v) : to;
      if (star(v, false).distortion < before.distortion) return;
    }
    x_[v] = from;
  }

  // ---- distances --------------------------------------------------------------------------------

  void vertexDistances(double* mean, double* max, std::vector<Index>* off) const {
    std::vector<double> distances(c_.vertexCount(), -1);
    parallelFor<Index>(
        c_.vertexCount(),
        [&](Index v) {
          if (c_.vertexOnBoundary(v)) distances[v] = (project_(x_[v], kNone) - x_[v]).norm();
        },
        context_, 64);
    summarise(distances, mean, max);
    if (!off) return;
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      if (distances[v] > kOnSurface * edge_) off->push_back(v);
    }
  }

  void facetDistances(BoundaryFitReport* report) const {
    std::vector<double> distances(c_.facetCount(), -1);
    parallelFor<Index>(
        c_.facetCount(),
        [&](Index f) {
          if (!c_.facetOnBoundary(f)) return;
          const auto [a, b, c] = c_.facetVertices(f);
          const Vec3 centre = (x_[a] + x_[b] + x_[c]) / 3;
          distances[f] = (project_(centre, kNone) - centre).norm();
        },
        context_, 64);
    summarise(distances, &report->meanFacet, &report->maxFacet);
  }

  static void summarise(const std::vector<double>& distances, double* mean, double* max) {
    double sum = 0, n = 0;
    *max = 0;
    for (const double d : distances) {
      if (d < 0) continue;
      sum += d;
      ++n;
      *max = std::max(*max, d);
    }
    *mean = n > 0 ? sum / n : 0;
  }

  const Complex& c_;
  Array<Vec3> x_;
  const ProjectToSurface& project_;
  const BoundaryFitOptions& options_;
  const Context& context_;
  double edge_ = 0, tetCorner_ = 0, octCorner_ = 0;
  std::vector<Index> movable_;
  std::vector<std::vector<Index>> groups_;
  std::vector<std::array<Index, 2>> edgeFacets_;
  std::vector<Index> facetBegin_, vertexFacets_;
  std::vector<std::uint8_t> awake_;  // 2: moved in this round
};

}  // namespace

Array<Vec3> fitBoundary(const ControlMesh& mesh, Array<Vec3> start, const ProjectToSurface& project,
                        const BoundaryFitOptions& options, BoundaryFitReport* report,
                        const Context& context) {
  return Fitter(mesh, std::move(start), project, options, context).run(report);
}

}  // namespace octet
