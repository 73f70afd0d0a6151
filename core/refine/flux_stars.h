// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "../base/parallel.h"
#include "../rules/star_fluxes.h"
#include "irregular_stars.h"

namespace octet {

/// @brief What irregular stars add to D2 L2 when a level is split: H2 of SCHEME.md sections 6b
/// and 6c, a sparse matrix from coarse facets to fine edges. Stored as the stars' own edges and
/// facets under shared patterns, so that a star costs some 350 bytes. Every fine edge belongs to
/// one star at most. Thread safe.
class FluxStars {
 public:
  FluxStars() = default;
  /// @param stars  of the level that is split
  FluxStars(const IrregularStars& stars, const Complex& fine);

  bool empty() const { return stars_.empty(); }

  /// Adds H2 times a coarse 2-form to a fine 1-form.
  void apply(const double* coarseFacets, double* fineEdges) const;

  /// Calls `add(coarse facet, weight)` for the row of a fine edge.
  template <typename Add>
  void row(Index fineEdge, double weight, const Add& add) const;

 private:
  struct Entry {
    const FluxPattern* pattern;
    std::size_t firstEdge, firstFacet;
  };
  /// A simplex as the pattern orients it.
  struct Oriented {
    std::uint32_t code = kUnknown;
    Oriented() = default;
    Oriented(Index index, bool reversed)
        : code(static_cast<std::uint32_t>(index) << 1 | static_cast<std::uint32_t>(reversed)) {}
    Index index() const { return static_cast<Index>(code >> 1); }
    double sign() const { return code & 1u ? -1 : 1; }
    bool found() const { return code != kUnknown; }
    static constexpr std::uint32_t kUnknown = 0xffffffffu;
  };
  class Finder;

  /// A star that has a pattern, and its vertices by label.
  struct Named {
    const FluxPattern* pattern;
    std::vector<Index> vertices;
  };
  void add(const std::vector<Named>& found, const Complex& coarse, const Complex& fine);
  void index();

  std::vector<Entry> stars_;
  Array<Oriented> edges_, facets_;
  Array<std::pair<Index, std::uint32_t>> places_;  // fine edges, ascending, and where in edges_
};

template <typename Add>
void FluxStars::row(Index fineEdge, double weight, const Add& add) const {
  const auto found = std::lower_bound(places_.begin(), places_.end(),
                                      std::pair<Index, std::uint32_t>(fineEdge, 0));
  if (found == places_.end() || found->first != fineEdge) return;
  const std::size_t at = found->second;
  const auto star = std::prev(
      std::upper_bound(stars_.begin(), stars_.end(), at,
                       [](std::size_t place, const Entry& s) { return place < s.firstEdge; }));
  const std::size_t edge = at - star->firstEdge;
  const auto& terms = star->pattern->terms;
  const auto begin = std::lower_bound(
      terms.begin(), terms.end(), edge,
      [](const FluxPattern::Term& term, std::size_t number) { return term.edge < number; });
  for (auto term = begin; term != terms.end() && term->edge == edge; ++term) {
    const Oriented facet = facets_[star->firstFacet + term->facet];
    add(facet.index(), weight * edges_[at].sign() * facet.sign() * term->weight);
  }
}

}  // namespace octet
