// SPDX-License-Identifier: Apache-2.0
#include "flux_stars.h"

#include <algorithm>
#include <array>
#include <map>

#include "star_sums.h"
#include "twin_stars.h"

namespace octet {

/// @brief Finds a pattern's simplices in a star: the fine edges in the places of the star's edges,
/// and its coarse facets.
class FluxStars::Finder {
 public:
  Finder(const FluxPattern& pattern, const Complex& coarse, const Complex& fine)
      : coarse_(coarse), fine_(fine) {
    for (const auto& [a, b] : pattern.edges) edges_.push_back(code(a, b));
    for (const auto& [a, b, c] : pattern.facets) facets_.push_back(code(a, b, c));
  }

  /// False where cells share more than a facet, so that the star is not the pattern's.
  /// @param vertices  by label
  bool find(const std::vector<Index>& vertices, Oriented* edges, Oriented* facets) const {
    std::fill(edges, edges + edges_.size(), Oriented());
    std::fill(facets, facets + facets_.size(), Oriented());
    coarse_.visitVertexStar(vertices[0], [&](const CellAtVertex& at) {
      std::array<std::uint8_t, 6> labels{};
      for (int k = 0; k < coarse_.cellVertexCount(at.cell); ++k) {
        const auto found = std::find(vertices.begin(), vertices.end(),  //
                                     coarse_.cellVertex(at.cell, k));
        labels[k] = static_cast<std::uint8_t>(found - vertices.begin());
      }
      if (coarse_.isTet(at.cell)) {
        addCell<Tetrahedron>(at, labels, edges, facets);
      } else {
        addCell<Octahedron>(at, labels, edges, facets);
      }
    });
    const auto found = [](const Oriented& simplex) { return simplex.found(); };
    return std::all_of(edges, edges + edges_.size(), found) &&
           std::all_of(facets, facets + facets_.size(), found);
  }

 private:
  using Code = std::uint32_t;
  /// Labels as one number; codes ascend as lists of labels do.
  static Code code(int a, int b, int c = 0) { return static_cast<Code>((a << 8 | b) << 8 | c); }

  template <typename Shape>
  void addCell(const CellAtVertex& at, const std::array<std::uint8_t, 6>& labels, Oriented* edges,
               Oriented* facets) const {
    const Index child = coarse_.children().cornerChild(at.cell, at.place);
    for (int k = 0; k < Shape::kEdges; ++k) {
      int i = Shape::edges[k][0], j = Shape::edges[k][1];
      if (labels[i] > labels[j]) std::swap(i, j);
      const int number = numberIn(edges_, code(labels[i], labels[j]));
      if (number < 0 || edges[number].found()) continue;
      const EdgeRef edge = fine_.cellEdge(child, i, j);
      edges[number] = Oriented(edge.index(), edge.reversed());
    }
    for (int k = 0; k < Shape::kFacets; ++k) {
      const FacetRef facet = localFacet<Shape>(coarse_, at.cell, k);
      int a = labels[Shape::facets[k][0]], b = labels[Shape::facets[k][1]],
          c = labels[Shape::facets[k][2]];
      bool reversed = facet.sign() < 0;
      const auto order = [&](int* x, int* y) {
        if (*x < *y) return;
        std::swap(*x, *y);
        reversed = !reversed;
      };
      order(&a, &b);
      order(&b, &c);
      order(&a, &b);
      const int number = numberIn(facets_, code(a, b, c));
      if (number >= 0) facets[number] = Oriented(facet.index(), reversed);
    }
  }

  /// The place of a code in a sorted list, or -1.
  static int numberIn(const std::vector<Code>& list, Code code) {
    const auto found = std::lower_bound(list.begin(), list.end(), code);
    return found != list.end() && *found == code ? static_cast<int>(found - list.begin()) : -1;
  }

  const Complex& coarse_;
  const Complex& fine_;
  std::vector<Code> edges_, facets_;
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
  std::map<const FluxPattern*, Finder> finders;
  for (const Named& star : found) {
    finders.try_emplace(star.pattern, *star.pattern, coarse, fine);
  }
  std::vector<std::uint8_t> matches(found.size());
  parallelFor<std::size_t>(
      found.size(),
      [&](std::size_t k) {
        matches[k] = finders.at(found[k].pattern)
                         .find(found[k].vertices, edges_.data() + stars_[k].firstEdge,
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
