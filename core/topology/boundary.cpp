// SPDX-License-Identifier: Apache-2.0
#include "boundary.h"

#include <algorithm>

#include "../base/parallel.h"
#include "../rules/smoothing_rules.h"

namespace octet {
Boundary::Boundary(const Complex& complex, const std::vector<Index>& corners,
                   const Boundary* coarse) {
  list(complex, coarse);
  buildRings(complex);
  classify(complex, corners);
  if (coarse) buildEdgeRows(complex);
}

void Boundary::list(const Complex& complex, const Boundary* coarse) {
  if (!coarse) {
    for (Index f = 0; f < complex.facetCount(); ++f) {
      if (complex.facetOnBoundary(f)) facets.push_back(f);
    }
    for (Index e = 0; e < complex.edgeCount(); ++e) {
      if (complex.edgeOnBoundary(e)) edges.push_back(e);
    }
    for (Index v = 0; v < complex.vertexCount(); ++v) {
      if (complex.vertexOnBoundary(v)) vertices.push_back(v);
    }
  } else {
    const ChildNumbering children = complex.coarse->children();
    for (const Index f : coarse->facets) {
      for (int k = 0; k < 4; ++k) facets.push_back(children.onFacet(f, k));
    }
    for (const Index e : coarse->edges) {
      for (int end = 0; end < 2; ++end) edges.push_back(children.half(e, end));
    }
    for (const Index f : coarse->facets) {
      for (int k = 0; k < 3; ++k) edges.push_back(children.cut(f, k));
    }
    vertices = coarse->vertices;
    for (const Index e : coarse->edges) vertices.push_back(children.midpoint(e));
  }
  rows_.assign(complex.vertexCount(), kNone);
  for (Index row = 0; row < vertexCount(); ++row) rows_[vertices[row]] = row;
}

void Boundary::buildRings(const Complex& complex) {
  ringBegin_.assign(vertices.size() + 1, 0);
  for (const Index f : facets) {
    for (const Index v : complex.facetVertices(f)) ++ringBegin_[rows_[v] + 1];
  }
  for (std::size_t k = 1; k < ringBegin_.size(); ++k) ringBegin_[k] += ringBegin_[k - 1];
  ring_.resize(ringBegin_.back());
  Array<Index> next(ringBegin_.begin(), ringBegin_.end() - 1);
  for (const Index f : facets) {
    const auto t = complex.facetVertices(f);
    const bool outward = complex.facetCells[f][0].exists();
    for (int k = 0; k < 3; ++k) {
      const int first = outward ? (k + 1) % 3 : (k + 2) % 3;
      ring_[next[rows_[t[k]]]++] = {complex.facetEdge(f, k, first), f,
                                    static_cast<std::int8_t>(outward ? 1 : -1), true};
    }
  }
  // Put each ring in order: the step whose edge is where the facet before ends. Where several rings
  // meet they follow each other.
  parallelFor<Index>(vertexCount(), [&](Index row) {
    RingStep* const begin = ring_.data() + ringBegin_[row];
    RingStep* const end = ring_.data() + ringBegin_[row + 1];
    for (RingStep* step = begin; step != end; ++step) {
      step->firstOfEdge = std::none_of(begin, step, [&](const RingStep& earlier) {
        return earlier.edge.index() == step->edge.index();
      });
      const auto following = std::find_if(step + 1, end, [&](const RingStep& candidate) {
        return facetHasEdge(complex, step->facet, candidate.edge.index());
      });
      if (following != end) std::swap(*(step + 1), *following);
    }
  });
}

Index Boundary::valence(Index row) const {
  return static_cast<Index>(std::count_if(ringBegin(row), ringEnd(row),
                                          [](const RingStep& step) { return step.firstOfEdge; }));
}

void Boundary::classify(const Complex& complex, const std::vector<Index>& corners) {
  kinds.resize(vertices.size());
  weights_.resize(vertices.size());
  regular_.resize(vertices.size());
  parallelFor<Index>(vertexCount(), [&](Index row) {
    int creases = 0;
    for (const RingStep* step = ringBegin(row); step != ringEnd(row); ++step) {
      if (step->firstOfEdge && complex.edgeFlags[step->edge.index()] & kOnCrease) ++creases;
    }
    const bool pinned = std::binary_search(corners.begin(), corners.end(), vertices[row]);
    kinds[row] = pinned || creases == 1 || creases > 2 ? BoundaryKind::Corner
                 : creases == 2                        ? BoundaryKind::Crease
                                                       : BoundaryKind::Smooth;
    weights_[row] = kinds[row] == BoundaryKind::Smooth   ? -2 * loopBeta(valence(row))
                    : kinds[row] == BoundaryKind::Crease ? -kCreaseWeight
                                                         : 0;
    constexpr Index kRegularValence = 6;
    bool regular = kinds[row] == BoundaryKind::Smooth && valence(row) == kRegularValence &&
                   ringEnd(row) - ringBegin(row) == kRegularValence;
    for (Index k = 0; k < kRegularValence && regular; ++k) {
      const Index next = ringBegin(row)[(k + 1) % kRegularValence].edge.index();
      regular = facetHasEdge(complex, ringBegin(row)[k].facet, next);
    }
    regular_[row] = regular;
  });
}

void Boundary::buildEdgeRows(const Complex& complex) {
  const ChildNumbering children = complex.coarse->children();
  const auto stepTo = [&](Index row, Index edge) {
    const RingStep* step = ringBegin(row);
    while (step->edge.index() != edge) ++step;
    return static_cast<Index>(step - ringBegin(row));
  };
  edgeRows_ = LocalRows(edges, [&](Index k, const auto& add) {
    // Boundary facets are quarters of coarse ones.
    const auto addFacet = [&](const RingStep& step, double weight) {
      add(children.facet(step.facet).parent, weight * step.facetSign / 4);
    };
    const Index e = edges[k];
    if (complex.edgeFlags[e] & kOnCrease) return;
    const Index u = rows_[complex.edges[e][0]], v = rows_[complex.edges[e][1]];
    if (regular(u) && regular(v)) {
      const Index atU = stepTo(u, e), atV = stepTo(v, e);
      for (const SurfaceTerm& term : kSurfaceEdgeTerms) {
        // Seen from v, the edge back to u is direction 3.
        const Index place =
            term.atEnd ? (atV + term.direction + 3) % 6 : (atU + term.direction) % 6;
        addFacet(ringBegin(term.atEnd ? v : u)[place], term.weight);
      }
      return;
    }
    for (const RingStep* step = ringBegin(u); step != ringEnd(u); ++step) {
      if (!facetHasEdge(complex, step->facet, e)) continue;
      // The facet that follows the edge around u has it counterclockwise, one before it clockwise.
      addFacet(*step, step->edge.index() == e ? kBoundaryEdgeWeight : -kBoundaryEdgeWeight);
    }
  });
}

}  // namespace octet
