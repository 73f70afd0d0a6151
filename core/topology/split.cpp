// SPDX-License-Identifier: Apache-2.0
#include "split.h"

#include <string>

#include "../base/error.h"
#include "../base/parallel.h"
#include "../rules/lattice.h"
#include "../rules/split_tables.h"

namespace octet {
namespace {

class Splitter {
 public:
  Splitter(const std::shared_ptr<const Complex>& coarse, Complex* fine)
      : c_(*coarse), f_(*fine), v_(c_.vertexCount()), e_(c_.edgeCount()), n_(c_.facetCount()) {
    f_.coarse = coarse;
  }

  void run() {
    const Index t = c_.tetCount(), o = c_.octCount();
    f_.vertexTypes.resize(v_ + e_ + o);
    f_.edges.resize(2 * e_ + 3 * n_ + 12 * o);
    f_.edgeFlags.resize(f_.edges.size());
    f_.facetEdges.resize(4 * n_ + 4 * t + 24 * o);
    f_.facetCells.resize(f_.facetEdges.size());
    f_.tets.resize(4 * t + 8 * o);
    f_.tetFacets.resize(f_.tets.size());
    f_.octs.resize(t + 6 * o);
    f_.octFacets.resize(f_.octs.size());
    f_.cellSigns.resize(f_.tets.size() + f_.octs.size());
    f_.cellRegions.resize(f_.cellSigns.size());
    f_.cellFrames.resize(f_.cellSigns.size());
    parallelFor<Index>(v_, [&](Index v) { f_.vertexTypes[v] = c_.vertexTypes[v]; });
    parallelFor<Index>(e_, [&](Index e) { splitEdge(e); });
    parallelFor<Index>(n_, [&](Index k) { splitFacet(k); });
    parallelFor<Index>(t, [&](Index k) { splitTet(k); });
    parallelFor<Index>(o, [&](Index k) { splitOct(k); });
    // Every facet is outward to at most one cell and inward to at most one: each cell writes its
    // own side.
    parallelFor<Index>(f_.cellCount(), [&](Index cell) {
      for (int k = 0; k < f_.cellFacetCount(cell); ++k) {
        const FacetRef facet = f_.cellFacet(cell, k);
        const bool outward = (f_.cellSigns[cell] > 0) == (facet.sign() > 0);
        f_.facetCells[facet.index()][outward ? 0 : 1] = CellSide(cell, k);
      }
    });
  }

 private:
  void splitEdge(Index e) {
    const auto [a, b] = c_.edges[e];
    f_.edges[2 * e] = {a, v_ + e};
    f_.edges[2 * e + 1] = {v_ + e, b};
    f_.edgeFlags[2 * e] = f_.edgeFlags[2 * e + 1] = c_.edgeFlags[e];
    f_.vertexTypes[v_ + e] = midpointType(e);
  }

  VertexType midpointType(Index e) const {
    const bool onEdge = c_.edgeFlags[e] & kOnControlEdge;
    if (c_.edgeOnBoundary(e)) return onEdge ? VertexType::B2 : VertexType::B1;
    if (!(c_.edgeFlags[e] & (kOnControlEdge | kOnControlFacet))) return VertexType::R;
    Index region = kNone;
    bool oneRegion = true;
    c_.visitEdgeStar(e, [&](const CellAtEdge& at) {
      const Index r = c_.cellRegions[at.cell];
      oneRegion &= region == kNone || region == r;
      region = r;
    });
    return oneRegion ? VertexType::R : onEdge ? VertexType::X2 : VertexType::X1;
  }

  /// Half of coarse edge `edge` at its end seen first (second) through the reference, seen outward
  /// from that end to the midpoint.
  static EdgeRef halfAtStart(EdgeRef edge) {
    return EdgeRef(2 * edge.index() + (edge.reversed() ? 1 : 0), edge.reversed());
  }
  static EdgeRef halfAtEnd(EdgeRef edge) {
    return EdgeRef(2 * edge.index() + (edge.reversed() ? 0 : 1), !edge.reversed());
  }

  /// Edge of a facet's split that cuts off the corner at a stored place.
  Index cutEdge(Index facet, int corner) const { return 2 * e_ + 3 * facet + corner; }

  void splitFacet(Index facet) {
    const auto& edges = c_.facetEdges[facet];
    const Index mid[3] = {v_ + edges[0].index(), v_ + edges[1].index(), v_ + edges[2].index()};
    const Index ab = mid[0], bc = mid[1], ac = mid[2];
    const Index first = cutEdge(facet, 0);
    f_.edges[first] = {ab, ac};
    f_.edges[first + 1] = {ab, bc};
    f_.edges[first + 2] = {ac, bc};
    std::uint8_t flags = c_.facetOnBoundary(facet) ? kOnBoundary : 0;
    if (onControlFacet(facet)) flags |= kOnControlFacet;
    for (int k = 0; k < 3; ++k) f_.edgeFlags[first + k] = flags;
    const EdgeRef cutA(first, false), cutB(first + 1, false), cutC(first + 2, false);
    auto* out = &f_.facetEdges[4 * facet];
    out[0] = {halfAtStart(edges[0]), cutA, halfAtEnd(edges[2]).flippedIf(true)};  // (a,ab,ac)
    out[1] = {halfAtEnd(edges[0]).flippedIf(true), halfAtStart(edges[1]),         // (ab,b,bc)
              cutB.flippedIf(true)};
    out[2] = {cutC, halfAtEnd(edges[1]).flippedIf(true), halfAtStart(edges[2])};  // (ac,bc,c)
    out[3] = {cutB, cutC.flippedIf(true), cutA.flippedIf(true)};                  // (ab,bc,ac)
  }

  /// Facets on the control mesh's facets come first at every level.
  bool onControlFacet(Index facet) const {
    const Complex* level = &c_;
    while (level->coarse) {
      level = level->coarse.get();
      facet /= 4;
      if (facet >= level->facetCount()) return false;
    }
    return true;
  }

  template <typename Facets>
  FacetRef childFacet(const ChildFacet& child, const Facets& facets, Index firstInside) const {
    if (child.inside) return FacetRef(firstInside + child.facet, child.arrangement);
    const FacetRef parent = facets[child.facet];
    const auto& slots = kPermutations[child.arrangement];
    if (child.corner < 3) {
      return FacetRef(4 * parent.index() + parent.place(child.corner),
                      permutationOf(parent.place(slots[0]), parent.place(slots[1])));
    }
    // In the middle child (ab,bc,ac) the midpoint that misses place m is at place m + 1.
    return FacetRef(4 * parent.index() + 3, permutationOf((parent.place(slots[0]) + 1) % 3,
                                                          (parent.place(slots[1]) + 1) % 3));
  }

  template <typename Facets>
  EdgeRef cutEdgeRef(const CutEdge& cut, const Facets& facets) const {
    const FacetRef parent = facets[cut.facet];
    const int to = 3 - cut.corner - cut.from;
    return EdgeRef(cutEdge(parent.index(), parent.place(cut.corner)),
                   parent.place(cut.from) > parent.place(to));
  }

  template <typename Shape, typename Facets, typename Vertices>
  void makeChildren(const Facets& facets, const Vertices& vertices, Index cell, Index firstTet,
                    Index firstOct, Index firstInside) {
    const auto& tables = SplitTables<Shape>::get();
    for (int k = 0; k < tables.kTets; ++k) {
      for (int i = 0; i < 4; ++i) f_.tets[firstTet + k][i] = vertices[tables.tets[k][i]];
      for (int i = 0; i < 4; ++i) {
        f_.tetFacets[firstTet + k][i] = childFacet(tables.tetFacets[k][i], facets, firstInside);
      }
      f_.cellRegions[firstTet + k] = c_.cellRegions[cell];
    }
    for (int k = 0; k < tables.kOcts; ++k) {
      for (int i = 0; i < 6; ++i) f_.octs[firstOct + k][i] = vertices[tables.octs[k][i]];
      for (int i = 0; i < 8; ++i) {
        f_.octFacets[firstOct + k][i] = childFacet(tables.octFacets[k][i], facets, firstInside);
      }
      f_.cellRegions[f_.tetCount() + firstOct + k] = c_.cellRegions[cell];
    }
  }

  void splitTet(Index tet) {
    const auto& facets = c_.tetFacets[tet];
    Index vertices[10];
    for (int i = 0; i < 4; ++i) vertices[i] = c_.tets[tet][i];
    for (int k = 0; k < 6; ++k) vertices[4 + k] = v_ + c_.tetEdge(tet, k).index();
    const Index firstInside = 4 * n_ + 4 * tet;
    makeChildren<Tetrahedron>(facets, vertices, tet, 4 * tet, tet, firstInside);

    const auto& tables = SplitTables<Tetrahedron>::get();
    for (int f = 0; f < 4; ++f) {
      for (int k = 0; k < 3; ++k) {
        f_.facetEdges[firstInside + f][k] = cutEdgeRef(tables.insideCuts[f][k], facets);
      }
    }
    const Index oct = f_.tetCount() + tet;
    const int frame = c_.cellFrames[tet];
    for (int k = 0; k < 4; ++k) {
      f_.cellSigns[4 * tet + k] = c_.cellSigns[tet];
      f_.cellFrames[4 * tet + k] = c_.cellFrames[tet];
    }
    // (ab,ac,ad,bd,bc,cd) turns the other way from (a,b,c,d).
    f_.cellSigns[oct] = static_cast<std::int8_t>(-c_.cellSigns[tet]);
    const Lattice& lattice = Lattice::get();
    f_.cellFrames[oct] = static_cast<std::uint8_t>(lattice.compose(frame, lattice.tetToOct));
  }

  void splitOct(Index oct) {
    const Index cell = c_.tetCount() + oct;
    const auto& facets = c_.octFacets[oct];
    Index vertices[19];
    for (int i = 0; i < 6; ++i) vertices[i] = c_.octs[oct][i];
    for (int k = 0; k < 12; ++k) vertices[6 + k] = v_ + c_.octEdge(oct, k).index();
    const Index centre = v_ + e_ + oct;
    vertices[kCentreLabel] = centre;
    f_.vertexTypes[centre] = VertexType::R;
    const Index firstTet = 4 * c_.tetCount() + 8 * oct, firstOct = c_.tetCount() + 6 * oct;
    const Index firstInside = 4 * n_ + 4 * c_.tetCount() + 24 * oct;
    makeChildren<Octahedron>(facets, vertices, cell, firstTet, firstOct, firstInside);

    const Index firstSpoke = 2 * e_ + 3 * n_ + 12 * oct;
    for (int k = 0; k < 12; ++k) {
      f_.edges[firstSpoke + k] = {centre, vertices[6 + k]};
      f_.edgeFlags[firstSpoke + k] = 0;
    }
    const auto& tables = SplitTables<Octahedron>::get();
    for (int f = 0; f < 24; ++f) {
      f_.facetEdges[firstInside + f] = {EdgeRef(firstSpoke + tables.insideSpokes[f][0], false),
                                        cutEdgeRef(tables.insideCuts[f][0], facets),
                                        EdgeRef(firstSpoke + tables.insideSpokes[f][1], true)};
    }
    const Lattice& lattice = Lattice::get();
    const int frame = c_.cellFrames[cell];
    for (int k = 0; k < 8; ++k) {
      // Outward (i,j,l) seen from the centre: (ij,jl,il,centre) is negatively oriented.
      f_.cellSigns[firstTet + k] = static_cast<std::int8_t>(-c_.cellSigns[cell]);
      f_.cellFrames[firstTet + k] =
          static_cast<std::uint8_t>(lattice.compose(frame, lattice.octToTet[k]));
    }
    for (int k = 0; k < 6; ++k) {
      f_.cellSigns[f_.tetCount() + firstOct + k] = c_.cellSigns[cell];
      f_.cellFrames[f_.tetCount() + firstOct + k] = c_.cellFrames[cell];
    }
  }

  const Complex& c_;
  Complex& f_;
  const Index v_, e_, n_;  // coarse vertices, edges, facets
};

}  // namespace

std::int64_t splitCellCount(const Complex& coarse) {
  return std::int64_t{5} * coarse.tetCount() + std::int64_t{14} * coarse.octCount();
}

std::shared_ptr<const Complex> split(const std::shared_ptr<const Complex>& coarse) {
  const std::int64_t edges = std::int64_t{2} * coarse->edgeCount() +
                             std::int64_t{3} * coarse->facetCount() +
                             std::int64_t{12} * coarse->octCount();
  const std::int64_t facets = std::int64_t{4} * (coarse->facetCount() + coarse->tetCount()) +
                              std::int64_t{24} * coarse->octCount();
  if (edges >= EdgeRef::kMaxEdges || facets >= FacetRef::kMaxFacets) {
    throw InputError("levels", "one more level would have " +
                                   std::to_string(splitCellCount(*coarse)) +
                                   " cells, more than can be numbered");
  }
  auto fine = std::make_shared<Complex>();
  Splitter(coarse, fine.get()).run();
  return fine;
}

}  // namespace octet
