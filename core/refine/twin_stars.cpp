// SPDX-License-Identifier: Apache-2.0
#include "twin_stars.h"

#include <algorithm>
#include <array>
#include <optional>

#include "../base/parallel.h"

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

std::vector<std::vector<Index>> twinStars(const IrregularStars& stars) {
  const Complex& complex = stars.complex();
  // Regular vertices have no facet between two cells of one kind.
  std::vector<Index> candidates;
  for (Index v = 0; v < complex.vertexCount(); ++v) {
    if (complex.vertexTypes[v] != VertexType::R && stars.kind(v) == StarKind::Plain) {
      candidates.push_back(v);
    }
  }
  std::vector<std::optional<std::vector<Index>>> names(candidates.size());
  parallelFor<std::size_t>(
      candidates.size(),
      [&](std::size_t k) { names[k] = TwinNames(complex, candidates[k]).find(); }, 64);
  std::vector<std::vector<Index>> found;
  for (auto& vertices : names) {
    if (vertices) found.push_back(std::move(*vertices));
  }
  return found;
}

}  // namespace octet
