// SPDX-License-Identifier: Apache-2.0
#include "wall_moves.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "../base/parallel.h"
#include "../rules/wall_rules.h"

namespace octet {
namespace {

constexpr int kMostLabels = 250;  // labels are bytes

/// Solves the rule of a star, or finds it among those solved before.
std::shared_ptr<const Eigen::MatrixXd> movesOf(const WallStar& star) {
  static std::mutex mutex;
  static std::map<WallStar, std::shared_ptr<const Eigen::MatrixXd>> solved;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = solved.find(star);
    if (found != solved.end()) return found->second;
  }
  auto moves = std::make_shared<const Eigen::MatrixXd>(wallStarMoves(star));
  const std::lock_guard<std::mutex> lock(mutex);
  return solved.emplace(star, std::move(moves)).first->second;
}

/// @brief A star as it lies in the mesh: which vertex bears each label, and the star's
/// combinatorics by labels.
struct LabelledStar {
  std::vector<Index> vertices;
  WallStar star;
};

/// @brief Labels the star of a boundary vertex by a walk that begins with its ring, so that labels
/// depend on where the ring begins and which way it turns, and on nothing else of the numbering.
class StarWalk {
 public:
  StarWalk(const Complex& complex, const Boundary& boundary, Index row)
      : c_(complex), boundary_(boundary), row_(row), centre_(boundary.vertices[row]) {}

  /// Is the wall around the vertex one closed ring of facets?
  bool ringCloses() const {
    const RingStep* const begin = boundary_.ringBegin(row_);
    const auto n = static_cast<Index>(boundary_.ringEnd(row_) - begin);
    if (n < 3 || boundary_.valence(row_) != n) return false;
    for (Index k = 0; k < n; ++k) {
      const Index next = begin[(k + 1) % n].edge.index();
      const auto& edges = c_.facetEdges[begin[k].facet];
      if (std::none_of(edges.begin(), edges.end(),
                       [&](const EdgeRef& e) { return e.index() == next; })) {
        return false;
      }
    }
    return true;
  }

  /// Is the star that of a lattice cut along a plane? Then there is nothing to move.
  bool regular() const {
    if (!boundary_.regular(row_)) return false;
    int tets = 0, octs = 0;
    c_.visitVertexStar(centre_,
                       [&](const CellAtVertex& at) { ++(c_.isTet(at.cell) ? tets : octs); });
    if (tets != 4 || octs != 3) return false;
    return std::all_of(boundary_.ringBegin(row_), boundary_.ringEnd(row_),
                       [&](const RingStep& step) {
                         int tetsAtEdge = 0, octsAtEdge = 0;
                         c_.visitEdgeStar(step.edge.index(), [&](const CellAtEdge& at) {
                           ++(c_.isTet(at.cell) ? tetsAtEdge : octsAtEdge);
                         });
                         return tetsAtEdge == 1 && octsAtEdge == 1;
                       });
  }

  /// The least of the labellings; none where the star is not a ball of cells joined at facets.
  std::optional<LabelledStar> canonical() {
    std::optional<LabelledStar> best;
    const int n = boundary_.valence(row_);
    for (int start = 0; start < n; ++start) {
      for (const int turn : {1, -1}) {
        std::optional<LabelledStar> candidate = label(start, turn);
        if (!candidate) return std::nullopt;
        if (!best || candidate->star < best->star) best = std::move(candidate);
      }
    }
    return best;
  }

 private:
  std::optional<LabelledStar> label(int start, int turn) {
    result_ = LabelledStar();
    labels_.clear();
    const RingStep* const ring = boundary_.ringBegin(row_);
    const int n = boundary_.valence(row_);
    result_.star.valence = n;
    result_.star.corner = boundary_.kinds[row_] == BoundaryKind::Corner;
    add(centre_);
    std::deque<Index> waiting;
    for (int k = 0; k < n; ++k) {
      const RingStep& step = ring[((start + turn * k) % n + n) % n];
      add(otherEnd(step.edge));
      const bool crease = c_.edgeFlags[step.edge.index()] & kOnCrease;
      result_.star.creases.push_back(crease ? 1 : 0);
    }
    for (int k = 0; k < n; ++k) {
      // The facet that follows the edge in the direction of the walk.
      const int at = turn > 0 ? start + k : start - k - 1;
      const auto& sides = c_.facetCells[ring[(at % n + n) % n].facet];
      waiting.push_back((sides[0].exists() ? sides[0] : sides[1]).cell());
    }
    std::vector<Index> seen;
    while (!waiting.empty()) {
      const Index cell = waiting.front();
      waiting.pop_front();
      if (std::find(seen.begin(), seen.end(), cell) != seen.end()) continue;
      seen.push_back(cell);
      if (!labelCell(cell) || result_.vertices.size() > kMostLabels) return std::nullopt;
      visitNeighbours(cell, [&](Index next) { waiting.push_back(next); });
    }
    std::size_t cells = 0;
    c_.visitVertexStar(centre_, [&](const CellAtVertex&) { ++cells; });
    if (cells != seen.size()) return std::nullopt;
    describe(seen);
    return std::move(result_);
  }

  void add(Index vertex) {
    labels_.emplace(vertex, static_cast<std::uint8_t>(result_.vertices.size()));
    result_.vertices.push_back(vertex);
  }
  int labelOf(Index vertex) const {
    const auto found = labels_.find(vertex);
    return found == labels_.end() ? kMostLabels + 1 : found->second;
  }
  Index otherEnd(EdgeRef e) const { return c_.edges[e.index()][e.reversed() ? 0 : 1]; }

  /// Labels what has none yet: in an octahedron what is opposite lower labels first.
  bool labelCell(Index cell) {
    const int count = c_.cellVertexCount(cell);
    std::vector<int> known;
    for (int k = 0; k < count; ++k) {
      if (labelOf(c_.cellVertex(cell, k)) <= kMostLabels) known.push_back(k);
    }
    if (known.size() < 3) return false;
    if (c_.isTet(cell)) {
      for (int k = 0; k < count; ++k) {
        if (labelOf(c_.cellVertex(cell, k)) > kMostLabels) add(c_.cellVertex(cell, k));
      }
      return true;
    }
    std::sort(known.begin(), known.end(), [&](int a, int b) {
      return labelOf(c_.cellVertex(cell, a)) < labelOf(c_.cellVertex(cell, b));
    });
    std::rotate(known.begin(), known.begin() + 1, known.end());  // m's opposite comes last
    for (const int k : known) {
      const Index across = c_.cellVertex(cell, Octahedron::opposite[k]);
      if (labelOf(across) > kMostLabels) add(across);
    }
    for (int k = 0; k < count; ++k) {
      if (labelOf(c_.cellVertex(cell, k)) > kMostLabels) return false;
    }
    return true;
  }

  /// Cells across the facets at the centre, in the order of the facets' labels.
  template <typename Visit>
  void visitNeighbours(Index cell, const Visit& visit) const {
    std::vector<std::pair<std::array<int, 3>, Index>> found;
    for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
      const Index facet = c_.cellFacet(cell, k).index();
      const auto vertices = c_.facetVertices(facet);
      if (std::find(vertices.begin(), vertices.end(), centre_) == vertices.end()) continue;
      std::array<int, 3> labels;
      for (int j = 0; j < 3; ++j) labels[j] = labelOf(vertices[j]);
      std::sort(labels.begin(), labels.end());
      for (const CellSide& side : c_.facetCells[facet]) {
        if (side.exists() && side.cell() != cell) found.emplace_back(labels, side.cell());
      }
    }
    std::sort(found.begin(), found.end());
    for (const auto& [labels, next] : found) visit(next);
  }

  void describe(const std::vector<Index>& cells) {
    WallStar& star = result_.star;
    star.vertexCount = static_cast<int>(result_.vertices.size());
    for (const Index cell : cells) {
      if (c_.isTet(cell)) {
        auto& tet = star.tets.emplace_back();
        for (int k = 0; k < 4; ++k) tet[k] = labels_.at(c_.cellVertex(cell, k));
        std::sort(tet.begin(), tet.end());
      } else {
        star.octs.push_back(describeOctahedron(cell));
      }
    }
    std::sort(star.tets.begin(), star.tets.end());
    std::sort(star.octs.begin(), star.octs.end());
  }

  /// From m over the pair with the least label and the other pair to m's opposite.
  std::array<std::uint8_t, 6> describeOctahedron(Index cell) const {
    std::vector<std::pair<std::uint8_t, std::uint8_t>> pairs;  // by their lower label
    for (int k = 0; k < 6; ++k) {
      const std::uint8_t a = labels_.at(c_.cellVertex(cell, k));
      const std::uint8_t b = labels_.at(c_.cellVertex(cell, Octahedron::opposite[k]));
      if (a < b) pairs.emplace_back(a, b);
    }
    std::sort(pairs.begin(), pairs.end());
    return {pairs[0].first,  pairs[1].first,  pairs[2].first,
            pairs[1].second, pairs[2].second, pairs[0].second};
  }

  const Complex& c_;
  const Boundary& boundary_;
  Index row_, centre_;
  LabelledStar result_;
  std::map<Index, std::uint8_t> labels_;
};

/// @brief How the children around a vertex are reached: for every label the fine vertex in its
/// place, and the coarse edges from m to it.
class StarPaths {
 public:
  StarPaths(const Complex& complex, const LabelledStar& labelled) : c_(complex) {
    const std::size_t count = labelled.vertices.size();
    places_.assign(count, kNone);
    paths_.resize(count);
    const Index centre = labelled.vertices[0];
    places_[0] = centre;
    c_.visitVertexStar(centre, [&](const CellAtVertex& at) {
      for (int k = 0; k < c_.cellVertexCount(at.cell); ++k) {
        if (k != at.place) addVertex(at, k, labelled);
      }
    });
  }

  /// Has every vertex of the star one place only?
  bool unique() const { return unique_; }
  Index place(int label) const { return places_[static_cast<std::size_t>(label)]; }

  /// Adds `weight` times (value at a label - value at m), as coarse edges: the edge itself, or the
  /// mean of the four paths across an octahedron.
  void add(int label, Index fineVertex, double weight, std::vector<VertexMove>* moves) const {
    const auto& path = paths_[static_cast<std::size_t>(label)];
    const double share = path.size() == 1 ? weight : weight / 4;
    for (const EdgeRef& e : path) moves->push_back({fineVertex, e.index(), share * e.sign()});
  }

 private:
  void addVertex(const CellAtVertex& at, int k, const LabelledStar& labelled) {
    const Index vertex = c_.cellVertex(at.cell, k);
    const auto label = static_cast<std::size_t>(
        std::find(labelled.vertices.begin(), labelled.vertices.end(), vertex) -
        labelled.vertices.begin());
    const bool across = !c_.isTet(at.cell) && Octahedron::opposite[at.place] == k;
    std::vector<EdgeRef> path;
    Index place;
    if (across) {
      place = c_.children().centre(at.cell - c_.tetCount());
      for (int p = 0; p < 6; ++p) {
        if (p == k || p == at.place) continue;
        path.push_back(c_.cellEdge(at.cell, at.place, p));
        path.push_back(c_.cellEdge(at.cell, p, k));
      }
    } else {
      path.push_back(c_.cellEdge(at.cell, at.place, k));
      place = c_.children().midpoint(path[0].index());
    }
    if (places_[label] != kNone && places_[label] != place) unique_ = false;
    places_[label] = place;
    paths_[label] = std::move(path);
  }

  const Complex& c_;
  bool unique_ = true;
  std::vector<Index> places_;
  std::vector<std::vector<EdgeRef>> paths_;
};

/// What one boundary vertex asks of the children around it; rows may be claimed by others too.
std::vector<VertexMove> claims(const Complex& coarse, const Boundary& boundary, Index row) {
  StarWalk walk(coarse, boundary, row);
  if (!walk.ringCloses() || walk.regular()) return {};
  const std::optional<LabelledStar> labelled = walk.canonical();
  if (!labelled) return {};
  const StarPaths paths(coarse, *labelled);
  if (!paths.unique()) return {};
  const std::shared_ptr<const Eigen::MatrixXd> moves = movesOf(labelled->star);
  constexpr double kNothing = 1e-15;
  std::vector<VertexMove> result;
  for (int a = 0; a < labelled->star.vertexCount; ++a) {
    // A child on the way to another part of the wall belongs to both, and stays.
    if (a > labelled->star.valence && coarse.vertexOnBoundary(labelled->vertices[a])) continue;
    if (moves->row(a).cwiseAbs().maxCoeff() < kNothing) continue;
    for (int q = 1; q < labelled->star.vertexCount; ++q) {
      const double weight = (*moves)(a, q);
      if (std::abs(weight) >= kNothing) paths.add(q, paths.place(a), -weight, &result);
    }
  }
  return result;
}

}  // namespace

std::vector<VertexMove> wallMoves(const Complex& coarse, const Boundary& boundary) {
  std::vector<std::vector<VertexMove>> claimed(static_cast<std::size_t>(boundary.vertexCount()));
  parallelFor<std::size_t>(
      claimed.size(),
      [&](std::size_t row) { claimed[row] = claims(coarse, boundary, static_cast<Index>(row)); },
      16);
  std::map<Index, int> claimants;
  std::vector<VertexMove> moves;
  for (const std::vector<VertexMove>& part : claimed) {
    Index last = kNone;
    for (const VertexMove& move : part) {
      if (move.fineVertex != last) ++claimants[move.fineVertex];
      last = move.fineVertex;
    }
    moves.insert(moves.end(), part.begin(), part.end());
  }
  for (VertexMove& move : moves) move.weight /= claimants[move.fineVertex];
  std::stable_sort(moves.begin(), moves.end(), [](const VertexMove& a, const VertexMove& b) {
    return a.fineVertex < b.fineVertex;
  });
  return moves;
}

}  // namespace octet
