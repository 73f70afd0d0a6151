// SPDX-License-Identifier: Apache-2.0
#include "lattice_fill.h"

#include <algorithm>
#include <cmath>

#include "../base/error.h"
#include "../base/reported_loop.h"
#include "box_cage.h"
#include "star_patterns.h"

namespace octet {
namespace {

/// Stars reach two lattice units beyond an interior vertex; one more keeps look-ups in range.
constexpr int kMargin = 3;
/// Vertices this near to the threshold, in spacings, may change for a better boundary.
constexpr double kChangeWithin = 0.75;
/// How many other faults of the boundary a place counts for at which the solid touches itself.
constexpr int kTouching = 6;
/// Rounds of changing one interior vertex for fewer faults, before vertices are only dropped.
constexpr int kRounds = 20;

/// Integer points of a box, numbered with z fastest.
struct LatticeBox {
  Int3 low{}, size{};

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  std::size_t at(const Int3& p) const {
    return (static_cast<std::size_t>(p[0] - low[0]) * static_cast<std::size_t>(size[1]) +
            static_cast<std::size_t>(p[1] - low[1])) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(p[2] - low[2]);
  }
  /// Calls visit(p) for the points at least `margin` within, in order.
  template <typename Visit>
  void visit(int margin, const Visit& visit) const {
    for (int i = margin; i < size[0] - margin; ++i) visitSlice(i, margin, visit);
  }
  template <typename Visit>
  void visitSlice(int i, int margin, const Visit& visit) const {
    for (int j = margin; j < size[1] - margin; ++j) {
      for (int k = margin; k < size[2] - margin; ++k) {
        visit(Int3{low[0] + i, low[1] + j, low[2] + k});
      }
    }
  }
};

bool even(const Int3& p) { return ((p[0] + p[1] + p[2]) & 1) == 0; }
Int3 plus(const Int3& p, const Int3& q) { return {p[0] + q[0], p[1] + q[1], p[2] + q[2]}; }

constexpr Int3 kOctahedron[6] = {{0, 0, 1},  {1, 0, 0},  {0, 1, 0},
                                 {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};

class Filler {
 public:
  Filler(const Box& bounds, const LatticeFillOptions& options, const Context& context)
      : options_(options), context_(context), centre_((bounds.min + bounds.max) / 2) {
    if (!(options.spacing > 0) || !std::isfinite(options.spacing)) {
      throw InputError("spacing", "is not a positive number");
    }
    if (bounds.empty() || !bounds.size().allFinite())
      throw InputError("", "there is nothing to fill");
    unit_ = options.spacing / std::sqrt(2.0);
    double points = 1;
    for (int k = 0; k < 3; ++k) points *= bounds.size()[k] / unit_ + 1;
    // Half of the points are vertices, and there are three cells for each vertex.
    if (!(points < 4.0 * kMostCageCells)) {
      throw InputError("spacing",
                       "is too fine: the body's box has some " +
                           std::to_string(static_cast<std::int64_t>(std::min(points * 1.5, 9e18))) +
                           " cells of that size");
    }
    for (int k = 0; k < 3; ++k) {
      const int half = static_cast<int>(std::ceil(bounds.size()[k] / 2 / unit_)) + kMargin + 1;
      box_.low[k] = -half;
      box_.size[k] = 2 * half + 1;
    }
  }

  ControlMeshInput run(const SignedDistance& distance, LatticeFillReport* report) {
    measure(distance);
    makeManifold();
    for (const std::uint8_t in : interior_) report_.interiorVertices += in;
    if (report_.interiorVertices == 0) tooCoarse();
    ControlMeshInput mesh = cells();
    if (report) *report = report_;
    return mesh;
  }

 private:
  Vec3 position(const Int3& p) const { return centre_ + unit_ * Vec3(p[0], p[1], p[2]); }
  bool interior(const Int3& p) const { return interior_[box_.at(p)] != 0; }

  void measure(const SignedDistance& distance) {
    distance_.assign(box_.count(), 0);
    interior_.assign(box_.count(), 0);
    const int slices = box_.size[0];
    constexpr int kChunk = 16;
    for (int first = 0; first < slices; first += kChunk) {
      context_.report(
          {"fill", static_cast<std::size_t>(first), static_cast<std::size_t>(slices), "slices"});
      const int count = std::min(kChunk, slices - first);
      parallelFor<int>(
          count,
          [&](int i) {
            box_.visitSlice(first + i, 0, [&](const Int3& p) {
              if (even(p)) distance_[box_.at(p)] = static_cast<float>(distance(position(p)));
            });
          },
          context_, 1);
    }
    deepest_ = 0;
    box_.visit(kMargin, [&](const Int3& p) {
      if (!even(p)) return;
      const double d = distance_[box_.at(p)];
      deepest_ = std::max(deepest_, -d);
      interior_[box_.at(p)] = -d > options_.depth * options_.spacing;
    });
  }

  [[noreturn]] void tooCoarse() const {
    throw InputError("spacing", "is too coarse: " + std::to_string(options_.spacing) +
                                    " leaves no cell inside the body, whose deepest lattice point "
                                    "lies " +
                                    std::to_string(deepest_) + " below its surface");
  }

  // ---- boundary ---------------------------------------------------------------------------------

  bool cellAt(const Int3& vertex, int c) const {
    if (interior(vertex)) return true;
    for (const Int3& q : patterns_.vertices(c)) {
      if (interior(plus(vertex, q))) return true;
    }
    return false;
  }

  std::uint16_t cellsAt(const Int3& vertex) const {
    std::uint16_t cells = 0;
    for (int c = 0; c < StarPatterns::kCells; ++c) {
      if (cellAt(vertex, c)) cells |= static_cast<std::uint16_t>(1u << c);
    }
    return cells;
  }

  bool touchesItself(const Int3& vertex) const {
    return !interior(vertex) && !patterns_.manifold(cellsAt(vertex));
  }

  /// What is wrong at a boundary vertex: that the solid touches itself, or edges and facets through
  /// the inside all of whose vertices are on the boundary. On a smooth surface there is no room for
  /// the cells on both sides of these.
  int faults(const Int3& vertex) const {
    if (interior(vertex)) return 0;
    const std::uint16_t cells = cellsAt(vertex);
    if (!patterns_.manifold(cells)) return kTouching;
    if (cells == 0) return 0;
    int n = 0;
    for (const StarPatterns::Joint& joint : patterns_.joints()) {
      n += (cells & joint.cells) == joint.cells &&
           std::none_of(joint.vertices.begin(), joint.vertices.end(),
                        [&](int v) { return interior(plus(vertex, patterns_.around()[v])); });
    }
    return n;
  }

  int faultsAround(const Int3& vertex) const {
    int n = faults(vertex);
    for (const Int3& q : patterns_.around()) n += faults(plus(vertex, q));
    return n;
  }

  /// How far a vertex is from the threshold, in spacings: what making it the other kind costs.
  double cost(const Int3& p) const {
    return std::abs(distance_[box_.at(p)] / options_.spacing + options_.depth);
  }

  void toggle(const Int3& p) { interior_[box_.at(p)] ^= 1; }

  bool withinMargin(const Int3& p) const {
    for (int k = 0; k < 3; ++k) {
      const int at = p[k] - box_.low[k];
      if (at < kMargin || at >= box_.size[k] - kMargin) return false;
    }
    return true;
  }

  /// Changes the one interior vertex that leaves the fewest faults around; false when none leaves
  /// fewer than now.
  bool improve(const Int3& vertex) {
    std::vector<Int3> candidates = {vertex};
    for (const Int3& q : patterns_.around()) candidates.push_back(plus(vertex, q));
    int bestGain = 0;
    double bestCost = 0;
    const Int3* best = nullptr;
    for (const Int3& p : candidates) {
      const double c = cost(p);
      if (!withinMargin(p) || c > kChangeWithin) continue;
      const int before = faultsAround(p);
      toggle(p);
      const int gain = before - faultsAround(p);
      toggle(p);
      if (gain > bestGain || (gain == bestGain && gain > 0 && c < bestCost)) {
        bestGain = gain;
        bestCost = c;
        best = &p;
      }
    }
    if (!best) return false;
    ++(interior(*best) ? report_.dropped : report_.added);
    toggle(*best);
    return true;
  }

  void dropShallowest(const Int3& vertex) {
    const Int3* best = nullptr;
    std::vector<Int3> around;
    for (const Int3& q : patterns_.around()) around.push_back(plus(vertex, q));
    for (const Int3& p : around) {
      if (interior(p) && (!best || distance_[box_.at(p)] > distance_[box_.at(*best)])) best = &p;
    }
    toggle(*best);  // a bad vertex has a cell, which has an interior vertex
    ++report_.dropped;
  }

  /// Boundary vertices for which `is` holds, in order.
  template <typename Is>
  std::vector<Int3> boundaryVertices(const Is& is) const {
    std::vector<std::vector<Int3>> slices(box_.size[0]);
    parallelFor<int>(
        box_.size[0] - 2,
        [&](int i) {
          box_.visitSlice(i + 1, 1, [&](const Int3& p) {
            if (even(p) && nearInterior(p) && is(p)) slices[i + 1].push_back(p);
          });
        },
        context_, 1);
    std::vector<Int3> all;
    for (const auto& slice : slices) all.insert(all.end(), slice.begin(), slice.end());
    return all;
  }

  /// Boundary vertices have an interior vertex around them.
  bool nearInterior(const Int3& p) const {
    for (int k = 0; k < 3; ++k) {
      const int at = p[k] - box_.low[k];
      if (at < 2 || at >= box_.size[k] - 2) return false;
    }
    return !interior(p) && std::any_of(patterns_.around().begin(), patterns_.around().end(),
                                       [&](const Int3& q) { return interior(plus(p, q)); });
  }

  void makeManifold() {
    const auto faulty = [&](const Int3& p) { return faults(p) > 0; };
    for (int round = 0; round < kRounds; ++round) {
      bool better = false;
      for (const Int3& p : boundaryVertices(faulty)) {
        context_.poll();
        if (faulty(p) && improve(p)) better = true;
      }
      if (!better) break;
    }
    // Dropping ends for certain.
    const auto touching = [&](const Int3& p) { return touchesItself(p); };
    for (auto list = boundaryVertices(touching); !list.empty(); list = boundaryVertices(touching)) {
      for (const Int3& p : list) {
        context_.poll();
        if (touching(p)) dropShallowest(p);
      }
    }
  }

  // ---- cells ------------------------------------------------------------------------------------

  Index number(const Int3& p, ControlMeshInput* mesh) {
    Index& n = numbers_[box_.at(p)];
    if (n == kNone) {
      n = static_cast<Index>(mesh->vertices.size());
      mesh->vertices.push_back(position(p));
    }
    return n;
  }

  template <std::size_t N>
  bool hasInterior(const std::array<Int3, N>& points) const {
    return std::any_of(points.begin(), points.end(), [&](const Int3& p) { return interior(p); });
  }

  ControlMeshInput cells() {
    ControlMeshInput mesh;
    mesh.creases.emplace();
    numbers_.assign(box_.count(), kNone);
    box_.visit(1, [&](const Int3& p) {
      std::array<Int3, 4> tet;
      std::size_t n = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const Int3 q = plus(p, {corner >> 2, corner >> 1 & 1, corner & 1});
        if (even(q)) tet[n++] = q;
      }
      if (hasInterior(tet)) {
        auto& cell = mesh.tets.emplace_back();
        for (std::size_t k = 0; k < 4; ++k) cell[k] = number(tet[k], &mesh);
      }
      if (even(p)) return;
      std::array<Int3, 6> oct;
      for (std::size_t k = 0; k < 6; ++k) oct[k] = plus(p, kOctahedron[k]);
      if (hasInterior(oct)) {
        auto& cell = mesh.octs.emplace_back();
        for (std::size_t k = 0; k < 6; ++k) cell[k] = number(oct[k], &mesh);
      }
    });
    countComponents(mesh);
    return mesh;
  }

  /// The boundary is a manifold, so parts that share a vertex share a facet.
  void countComponents(const ControlMeshInput& mesh) {
    std::vector<Index> parent(mesh.vertices.size());
    for (std::size_t k = 0; k < parent.size(); ++k) parent[k] = static_cast<Index>(k);
    const auto root = [&](Index v) {
      while (parent[v] != v) v = parent[v] = parent[parent[v]];
      return v;
    };
    const auto join = [&](const auto& cells) {
      for (const auto& cell : cells) {
        for (const Index v : cell) parent[root(v)] = root(cell[0]);
      }
    };
    join(mesh.tets);
    join(mesh.octs);
    for (std::size_t k = 0; k < parent.size(); ++k) {
      report_.components += parent[k] == static_cast<Index>(k);
    }
  }

  const LatticeFillOptions& options_;
  const Context& context_;
  Vec3 centre_;
  double unit_ = 0;  // lattice unit: edges are sqrt(2) long
  LatticeBox box_;
  StarPatterns patterns_;
  Array<float> distance_;
  Array<std::uint8_t> interior_;
  Array<Index> numbers_;
  double deepest_ = 0;
  LatticeFillReport report_;
};

}  // namespace

ControlMeshInput fillLattice(const Box& bounds, const SignedDistance& distance,
                             const LatticeFillOptions& options, LatticeFillReport* report,
                             const Context& context) {
  return Filler(bounds, options, context).run(distance, report);
}

}  // namespace octet
