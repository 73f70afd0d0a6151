// SPDX-License-Identifier: Apache-2.0
#include "flux_stars.h"

#include <array>
#include <optional>

namespace octet {
namespace {

/// Labels of a twin star (lineFluxes' and twinFluxes' comments): m, r_j, u_k, w_k, p_k, q_k.
constexpr int kRing = 1, kAbove = 7, kBelow = 10, kFarAbove = 13, kFarBelow = 16, kTwinLabels = 19;

/// @brief Names the vertices around one whose star is the lattice and its mirror image across a
/// facet's plane, if it is such.
class TwinNames {
 public:
  TwinNames(const Complex& complex, Index centre) : c_(complex), centre_(centre) {}

  std::optional<std::vector<Index>> find() {
    constexpr int kCells = 14;
    int cells = 0;
    c_.visitVertexStar(centre_, [&](const CellAtVertex&) { ++cells; });
    if (cells != kCells) return std::nullopt;
    listTwinFacets();
    if (facets_.size() != 6 || !orderRing()) return std::nullopt;
    names_.assign(kTwinLabels, kNone);
    names_[0] = centre_;
    for (int j = 0; j < 6; ++j) names_[kRing + j] = ring_[static_cast<std::size_t>(j)];
    if (!nameTetrahedra() || !nameOctahedra()) return std::nullopt;
    std::array<Index, kTwinLabels> sorted;
    std::copy(names_.begin(), names_.end(), sorted.begin());
    std::sort(sorted.begin(), sorted.end());
    const bool distinct = std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end();
    return distinct ? std::make_optional(names_) : std::nullopt;
  }

 private:
  /// A facet at the vertex with cells of one kind on both sides: its other two vertices.
  struct TwinFacet {
    std::array<Index, 2> vertices;
    std::array<Index, 2> cells;
  };

  void listTwinFacets() {
    c_.visitVertexStar(centre_, [&](const CellAtVertex& at) {
      for (int k = 0; k < c_.cellFacetCount(at.cell); ++k) {
        const Index facet = c_.cellFacet(at.cell, k).index();
        const auto& sides = c_.facetCells[facet];
        if (!sides[0].exists() || !sides[1].exists() || sides[0].cell() != at.cell ||
            c_.isTet(at.cell) != c_.isTet(sides[1].cell())) {
          continue;
        }
        const auto t = c_.facetVertices(facet);
        const auto where = std::find(t.begin(), t.end(), centre_);
        if (where == t.end()) continue;
        const auto p = static_cast<std::size_t>(where - t.begin());
        facets_.push_back({{t[(p + 1) % 3], t[(p + 2) % 3]}, {sides[0].cell(), sides[1].cell()}});
      }
    });
  }

  const TwinFacet* facetWith(Index a, Index b) const {
    for (const TwinFacet& facet : facets_) {
      if ((facet.vertices[0] == a && facet.vertices[1] == b) ||
          (facet.vertices[0] == b && facet.vertices[1] == a)) {
        return &facet;
      }
    }
    return nullptr;
  }

  /// The hexagon, from a facet between tetrahedra on.
  bool orderRing() {
    const auto first = std::find_if(facets_.begin(), facets_.end(),
                                    [&](const TwinFacet& f) { return c_.isTet(f.cells[0]); });
    if (first == facets_.end()) return false;
    ring_ = {first->vertices[0], first->vertices[1]};
    while (ring_.size() < 6) {
      const Index last = ring_.back(), before = ring_[ring_.size() - 2];
      Index next = kNone;
      for (const TwinFacet& facet : facets_) {
        for (int k = 0; k < 2; ++k) {
          if (facet.vertices[k] != last || facet.vertices[1 - k] == before) continue;
          if (next != kNone) return false;
          next = facet.vertices[1 - k];
        }
      }
      if (next == kNone || std::find(ring_.begin(), ring_.end(), next) != ring_.end()) return false;
      ring_.push_back(next);
    }
    return true;
  }

  bool nameTetrahedra() {
    for (int k = 0; k < 3; ++k) {
      const Index a = ring_[static_cast<std::size_t>(2 * k)];
      const Index b = ring_[static_cast<std::size_t>(2 * k + 1)];
      const TwinFacet* const facet = facetWith(a, b);
      if (!facet || !c_.isTet(facet->cells[0])) return false;
      names_[kAbove + k] = tip(facet->cells[0], a, b);
      names_[kBelow + k] = tip(facet->cells[1], a, b);
    }
    return true;
  }

  /// Octahedra say which tetrahedra lie on one side.
  bool nameOctahedra() {
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const Index a = ring_[static_cast<std::size_t>(2 * k + 1)];
      const Index b = ring_[static_cast<std::size_t>((2 * k + 2) % 6)];
      const TwinFacet* const facet = facetWith(a, b);
      if (!facet || c_.isTet(facet->cells[0])) return false;
      for (const bool below : {false, true}) {
        const int near = below ? kBelow : kAbove, other = below ? kAbove : kBelow;
        Index cell = kNone;
        for (const Index candidate : facet->cells) {
          if (place(candidate, names_[near + k]) < 0) continue;
          if (cell != kNone) return false;
          cell = candidate;
        }
        if (cell == kNone) return false;
        const Index ahead = opposite(cell, a);
        if (names_[near + next] != ahead) {  // the next pair was named upside down
          if (k == 2 || names_[other + next] != ahead) return false;
          std::swap(names_[near + next], names_[other + next]);
        }
        names_[(below ? kFarBelow : kFarAbove) + k] = opposite(cell, centre_);
      }
    }
    return true;
  }

  int place(Index cell, Index vertex) const {
    for (int k = 0; k < c_.cellVertexCount(cell); ++k) {
      if (c_.cellVertex(cell, k) == vertex) return k;
    }
    return -1;
  }
  Index opposite(Index oct, Index vertex) const {
    return c_.cellVertex(oct, Octahedron::opposite[place(oct, vertex)]);
  }
  Index tip(Index tet, Index a, Index b) const {
    for (int k = 0; k < 4; ++k) {
      const Index v = c_.cellVertex(tet, k);
      if (v != centre_ && v != a && v != b) return v;
    }
    return kNone;
  }

  const Complex& c_;
  Index centre_;
  std::vector<TwinFacet> facets_;
  std::vector<Index> ring_, names_;
};

}  // namespace

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
  // Vertices in a facet between two cells of one kind; regular ones have none such.
  std::vector<Index> candidates;
  for (Index v = 0; v < coarse.vertexCount(); ++v) {
    if (coarse.vertexTypes[v] != VertexType::R && stars.kind(v) == StarKind::Plain) {
      candidates.push_back(v);
    }
  }
  std::vector<std::optional<std::vector<Index>>> twins(candidates.size());
  parallelFor<std::size_t>(
      candidates.size(), [&](std::size_t k) { twins[k] = TwinNames(coarse, candidates[k]).find(); },
      64);
  for (auto& names : twins) {
    if (names) found.push_back({&twinFluxes(), std::move(*names)});
  }
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
