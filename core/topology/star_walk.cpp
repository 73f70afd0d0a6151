// SPDX-License-Identifier: Apache-2.0
#include "star_walk.h"

#include <algorithm>
#include <array>
#include <deque>

#include "../base/sort_unique.h"

namespace octet {
namespace {

constexpr int kMostLabels = 250;  // labels are bytes

class Walk {
 public:
  Walk(const Complex& complex, Index centre) : c_(complex), centre_(centre) { add(centre); }

  std::optional<LabelledStar> run(const std::vector<Index>& first,
                                  const std::vector<Index>& cells) {
    for (const Index v : first) add(v);
    std::deque<Index> waiting(cells.begin(), cells.end());
    std::vector<Index> seen;
    while (!waiting.empty()) {
      const Index cell = waiting.front();
      waiting.pop_front();
      if (std::find(seen.begin(), seen.end(), cell) != seen.end()) continue;
      seen.push_back(cell);
      if (!labelCell(cell) || result_.vertices.size() > kMostLabels) return std::nullopt;
      visitNeighbours(cell, [&](Index next) { waiting.push_back(next); });
    }
    std::size_t count = 0;
    c_.visitVertexStar(centre_, [&](const CellAtVertex&) { ++count; });
    if (count != seen.size()) return std::nullopt;
    describe(seen);
    return std::move(result_);
  }

 private:
  void add(Index vertex) { result_.vertices.push_back(vertex); }
  /// The label of a vertex, or -1.
  int labelOf(Index vertex) const {
    const auto& list = result_.vertices;
    const auto found = std::find(list.begin(), list.end(), vertex);
    return found == list.end() ? -1 : static_cast<int>(found - list.begin());
  }

  /// Labels what has none yet: in an octahedron what is opposite lower labels first, what is
  /// opposite the centre last.
  bool labelCell(Index cell) {
    const int count = c_.cellVertexCount(cell);
    std::vector<std::pair<int, int>> known;  // label and place
    for (int k = 0; k < count; ++k) {
      const int label = labelOf(c_.cellVertex(cell, k));
      if (label >= 0) known.emplace_back(label, k);
    }
    if (known.size() < 3) return false;
    std::sort(known.begin(), known.end());
    if (c_.isTet(cell)) {
      for (int k = 0; k < count; ++k) {
        if (labelOf(c_.cellVertex(cell, k)) < 0) add(c_.cellVertex(cell, k));
      }
      return true;
    }
    std::rotate(known.begin(), known.begin() + 1, known.end());
    for (const auto& [label, place] : known) {
      const Index across = c_.cellVertex(cell, Octahedron::opposite[place]);
      if (labelOf(across) < 0) add(across);
    }
    for (int k = 0; k < count; ++k) {
      if (labelOf(c_.cellVertex(cell, k)) < 0) return false;
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
    Star& star = result_.star;
    star.vertexCount = static_cast<int>(result_.vertices.size());
    for (const Index cell : cells) {
      if (c_.isTet(cell)) {
        auto& tet = star.tets.emplace_back();
        for (int k = 0; k < 4; ++k) {
          tet[k] = static_cast<std::uint8_t>(labelOf(c_.cellVertex(cell, k)));
        }
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
    std::array<std::pair<std::uint8_t, std::uint8_t>, 3> pairs;  // by their lower label
    int n = 0;
    for (int k = 0; k < 6; ++k) {
      const auto a = static_cast<std::uint8_t>(labelOf(c_.cellVertex(cell, k)));
      const auto b =
          static_cast<std::uint8_t>(labelOf(c_.cellVertex(cell, Octahedron::opposite[k])));
      if (a < b) pairs[n++] = {a, b};
    }
    std::sort(pairs.begin(), pairs.end());
    return {pairs[0].first,  pairs[1].first,  pairs[2].first,
            pairs[1].second, pairs[2].second, pairs[0].second};
  }

  const Complex& c_;
  Index centre_;
  LabelledStar result_;
};

}  // namespace

std::optional<LabelledStar> walkStar(const Complex& complex, Index centre,
                                     const std::vector<Index>& first,
                                     const std::vector<Index>& cells) {
  return Walk(complex, centre).run(first, cells);
}

StarPaths::StarPaths(const Complex& complex, const std::vector<Index>& vertices)
    : places_(vertices.size(), kNone), begin_(vertices.size() + 1, 0) {
  struct Found {
    std::size_t label;
    EdgeRef edge;
    double share;
  };
  std::vector<Found> found;
  std::vector<char> listed(vertices.size(), 0);
  const auto labelOf = [&](Index v) {
    return static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) -
                                    vertices.begin());
  };
  places_[0] = vertices[0];
  complex.visitVertexStar(vertices[0], [&](const CellAtVertex& at) {
    for (int k = 0; k < complex.cellVertexCount(at.cell); ++k) {
      if (k == at.place) continue;
      const std::size_t label = labelOf(complex.cellVertex(at.cell, k));
      const bool across = !complex.isTet(at.cell) && Octahedron::opposite[at.place] == k;
      const Index place =
          across ? complex.children().centre(at.cell - complex.tetCount())
                 : complex.children().midpoint(complex.cellEdge(at.cell, at.place, k).index());
      if (places_[label] != kNone && places_[label] != place) unique_ = false;
      places_[label] = place;
      if (listed[label]) continue;
      listed[label] = 1;
      if (!across) {
        found.push_back({label, complex.cellEdge(at.cell, at.place, k), 1});
        continue;
      }
      for (int p = 0; p < 6; ++p) {
        if (p == k || p == at.place) continue;
        found.push_back({label, complex.cellEdge(at.cell, at.place, p), 1.0 / 4});
        found.push_back({label, complex.cellEdge(at.cell, p, k), 1.0 / 4});
      }
    }
  });
  for (const Found& step : found) edges_.push_back(step.edge.index());
  sortUnique(&edges_);
  for (const Found& step : found) ++begin_[step.label + 1];
  for (std::size_t k = 1; k < begin_.size(); ++k) begin_[k] += begin_[k - 1];
  steps_.resize(found.size());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (const Found& step : found) {
    const auto edge = std::lower_bound(edges_.begin(), edges_.end(), step.edge.index());
    steps_[next[step.label]++] = {static_cast<std::size_t>(edge - edges_.begin()),
                                  step.edge.sign() * step.share};
  }
}

}  // namespace octet
