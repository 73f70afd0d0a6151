// SPDX-License-Identifier: Apache-2.0
#include "flux_stars.h"

#include <algorithm>
#include <array>

#include "twin_stars.h"

namespace octet {

/// @brief Finds a pattern's simplices in a star: the fine edges in the places of the star's edges,
/// and its coarse facets.
class FluxStars::Finder {
 public:
  Finder(const FluxPattern& pattern, const Complex& coarse, const Complex& fine)
      : pattern_(pattern), coarse_(coarse), fine_(fine) {}

  /// False where cells share more than a facet, so that the star is not the pattern's.
  /// @param vertices  by label
  bool find(const std::vector<Index>& vertices, Oriented* edges, Oriented* facets) const {
    std::fill(edges, edges + pattern_.edges.size(), Oriented());
    std::fill(facets, facets + pattern_.facets.size(), Oriented());
    coarse_.visitVertexStar(vertices[0],
                            [&](const CellAtVertex& at) { addCell(at, vertices, edges, facets); });
    const auto found = [](const Oriented& simplex) { return simplex.found(); };
    return std::all_of(edges, edges + pattern_.edges.size(), found) &&
           std::all_of(facets, facets + pattern_.facets.size(), found);
  }

 private:
  void addCell(const CellAtVertex& at, const std::vector<Index>& vertices, Oriented* edges,
               Oriented* facets) const {
    const Index child = coarse_.children().cornerChild(at.cell, at.place);
    const int count = coarse_.cellVertexCount(at.cell);
    const auto labelOf = [&](Index vertex) {
      return static_cast<std::uint8_t>(std::find(vertices.begin(), vertices.end(), vertex) -
                                       vertices.begin());
    };
    std::array<std::uint8_t, 6> labels{};
    for (int k = 0; k < count; ++k) labels[k] = labelOf(coarse_.cellVertex(at.cell, k));
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        if (labels[i] >= labels[j] || (count == 6 && Octahedron::opposite[i] == j)) continue;
        const int number = numberIn(pattern_.edges, {labels[i], labels[j]});
        if (number < 0 || edges[number].found()) continue;
        const EdgeRef edge = fine_.cellEdge(child, i, j);
        edges[number] = Oriented(edge.index(), edge.reversed());
      }
    }
    for (int k = 0; k < coarse_.cellFacetCount(at.cell); ++k) {
      const Index facet = coarse_.cellFacet(at.cell, k).index();
      const auto stored = coarse_.facetVertices(facet);
      std::array<std::uint8_t, 3> ordered;
      for (int j = 0; j < 3; ++j) ordered[j] = labelOf(stored[j]);
      bool reversed = false;
      for (int i = 0; i < 3; ++i) {
        for (int j = i + 1; j < 3; ++j) reversed ^= ordered[i] > ordered[j];
      }
      std::sort(ordered.begin(), ordered.end());
      const int number = numberIn(pattern_.facets, ordered);
      if (number >= 0) facets[number] = Oriented(facet, reversed);
    }
  }

  /// The place of labels in a sorted list, or -1.
  template <typename Labels>
  static int numberIn(const std::vector<Labels>& list, const Labels& labels) {
    const auto found = std::lower_bound(list.begin(), list.end(), labels);
    return found != list.end() && *found == labels ? static_cast<int>(found - list.begin()) : -1;
  }

  const FluxPattern& pattern_;
  const Complex& coarse_;
  const Complex& fine_;
};

FluxStars::FluxStars(const IrregularStars& stars, const Complex& fine) {
  const Complex& coarse = stars.complex();
  std::vector<Named> found;
  for (const LineStar& line : stars.lines()) {
    const LineNames names = stars.names(line);
    const FluxPattern& pattern = lineFluxes(names.size());
    if (pattern.edges.empty()) continue;
    const auto plain = [&](const std::vector<Index>& list) {
      return std::all_of(list.begin(), list.end(),
                         [&](Index v) { return stars.kind(v) == StarKind::Plain; });
    };
    if (!plain(names.upper) || !plain(names.lower) || !plain(names.beyond)) continue;
    found.push_back({&pattern, names.list()});
  }
  for (auto& vertices : twinStars(stars)) found.push_back({&twinFluxes(), std::move(vertices)});
  add(found, coarse, fine);
  index();
}

void FluxStars::add(const std::vector<Named>& found, const Complex& coarse, const Complex& fine) {
  std::size_t edges = 0, facets = 0;
  for (const Named& star : found) {
    stars_.push_back({star.pattern, edges, facets});
    edges += star.pattern->edges.size();
    facets += star.pattern->facets.size();
  }
  edges_.resize(edges);
  facets_.resize(facets);
  std::vector<char> matches(found.size());
  parallelFor<std::size_t>(
      found.size(),
      [&](std::size_t k) {
        const Finder finder(*found[k].pattern, coarse, fine);
        matches[k] = finder.find(found[k].vertices, edges_.data() + stars_[k].firstEdge,
                                 facets_.data() + stars_[k].firstFacet);
      },
      64);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (matches[k]) stars_[kept++] = stars_[k];
  }
  stars_.resize(kept);
}

void FluxStars::index() {
  std::size_t count = 0;
  for (const Entry& star : stars_) count += star.pattern->edges.size();
  places_.resize(count);
  count = 0;
  for (const Entry& star : stars_) {
    for (std::size_t k = star.firstEdge; k < star.firstEdge + star.pattern->edges.size(); ++k) {
      places_[count++] = {edges_[k].index(), static_cast<std::uint32_t>(k)};
    }
  }
  std::sort(places_.begin(), places_.end());
}

void FluxStars::apply(const double* coarseFacets, double* fineEdges) const {
  parallelRanges<std::size_t>(
      stars_.size(),
      [&](std::size_t first, std::size_t last) {
        std::vector<double> facets, edges;
        for (std::size_t s = first; s < last; ++s) {
          const Entry& star = stars_[s];
          facets.resize(star.pattern->facets.size());
          edges.assign(star.pattern->edges.size(), 0);
          for (std::size_t k = 0; k < facets.size(); ++k) {
            const Oriented facet = facets_[star.firstFacet + k];
            facets[k] = facet.sign() * coarseFacets[facet.index()];
          }
          for (const FluxPattern::Term& term : star.pattern->terms) {
            edges[term.edge] += term.weight * facets[term.facet];
          }
          for (std::size_t k = 0; k < edges.size(); ++k) {
            const Oriented edge = edges_[star.firstEdge + k];
            fineEdges[edge.index()] += edge.sign() * edges[k];
          }
        }
      },
      64);
}

}  // namespace octet
