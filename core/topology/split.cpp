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
      : c_(*coarse), f_(*fine), children_(c_.children()) {
    f_.coarse = coarse;
  }

  void run() {
    const Index t = c_.tetCount(), o = c_.octCount();
    f_.vertexTypes.resize(children_.vertexCount());
    f_.edges.resize(children_.edgeCount());
    f_.edgeFlags.resize(f_.edges.size());
    f_.facetEdges.resize(children_.facetCount());
    f_.facetCells.resize(f_.facetEdges.size());
    f_.tets.resize(children_.tetCount());
    f_.tetFacets.resize(f_.tets.size());
    f_.octs.resize(children_.octCount());
    f_.octFacets.resize(f_.octs.size());
    f_.cellSigns.resize(f_.tets.size() + f_.octs.size());
    f_.cellRegions.resize(f_.cellSigns.size());
    f_.cellFrames.resize(f_.cellSigns.size());
    parallelFor<Index>(c_.vertexCount(), [&](Index v) { f_.vertexTypes[v] = c_.vertexTypes[v]; });
    parallelFor<Index>(c_.edgeCount(), [&](Index e) { splitEdge(e); });
    parallelFor<Index>(c_.facetCount(), [&](Index k) { splitFacet(k); });
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
    const Index midpoint = children_.midpoint(e);
    f_.edges[children_.half(e, 0)] = {a, midpoint};
    f_.edges[children_.half(e, 1)] = {midpoint, b};
    for (int end = 0; end < 2; ++end) f_.edgeFlags[children_.half(e, end)] = c_.edgeFlags[e];
    f_.vertexTypes[midpoint] = midpointType(e);
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
  EdgeRef halfAtStart(EdgeRef edge) const {
    return EdgeRef(children_.half(edge.index(), edge.reversed() ? 1 : 0), edge.reversed());
  }
  EdgeRef halfAtEnd(EdgeRef edge) const {
    return EdgeRef(children_.half(edge.index(), edge.reversed() ? 0 : 1), !edge.reversed());
  }

  void splitFacet(Index facet) {
    const auto& edges = c_.facetEdges[facet];
    const Index ab = children_.midpoint(edges[0].index());
    const Index bc = children_.midpoint(edges[1].index());
    const Index ac = children_.midpoint(edges[2].index());
    const Index atA = children_.cut(facet, 0), atB = children_.cut(facet, 1),
                atC = children_.cut(facet, 2);
    f_.edges[atA] = {ab, ac};
    f_.edges[atB] = {ab, bc};
    f_.edges[atC] = {ac, bc};
    std::uint8_t flags = c_.facetOnBoundary(facet) ? kOnBoundary : 0;
    if (onControlFacet(facet)) flags |= kOnControlFacet;
    for (const Index cut : {atA, atB, atC}) f_.edgeFlags[cut] = flags;
    const EdgeRef cutA(atA, false), cutB(atB, false), cutC(atC, false);
    auto* out = &f_.facetEdges[children_.onFacet(facet, 0)];
    out[0] = {halfAtStart(edges[0]), cutA, halfAtEnd(edges[2]).flippedIf(true)};  // (a,ab,ac)
    out[1] = {halfAtEnd(edges[0]).flippedIf(true), halfAtStart(edges[1]),         // (ab,b,bc)
              cutB.flippedIf(true)};
    out[2] = {cutC, halfAtEnd(edges[1]).flippedIf(true), halfAtStart(edges[2])};  // (ac,bc,c)
    out[3] = {cutB, cutC.flippedIf(true), cutA.flippedIf(true)};                  // (ab,bc,ac)
  }

  bool onControlFacet(Index facet) const {
    for (const Complex* level = c_.coarse.get(); level; level = level->coarse.get()) {
      const ChildOf child = level->children().facet(facet);
      if (child.origin != Origin::Facet) return false;
      facet = child.parent;
    }
    return true;
  }

  template <typename Facets>
  FacetRef childFacet(const ChildFacet& child, const Facets& facets, Index firstInside) const {
    if (child.inside) return FacetRef(firstInside + child.facet, child.arrangement);
    const FacetRef parent = facets[child.facet];
    const auto& slots = kPermutations[child.arrangement];
    if (child.corner < 3) {
      return FacetRef(children_.onFacet(parent.index(), parent.place(child.corner)),
                      permutationOf(parent.place(slots[0]), parent.place(slots[1])));
    }
    // In the middle child (ab,bc,ac) the midpoint that misses place m is at place m + 1.
    return FacetRef(
        children_.onFacet(parent.index(), 3),
        permutationOf((parent.place(slots[0]) + 1) % 3, (parent.place(slots[1]) + 1) % 3));
  }

  template <typename Facets>
  EdgeRef cutEdgeRef(const CutEdge& cut, const Facets& facets) const {
    const FacetRef parent = facets[cut.facet];
    const int to = 3 - cut.corner - cut.from;
    return EdgeRef(children_.cut(parent.index(), parent.place(cut.corner)),
                   parent.place(cut.from) > parent.place(to));
  }

  /// @param firstTet, firstOct  the cell's first child of each shape
  /// @param firstInside         the first facet inside it
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
      const Index oct = firstOct + k - f_.tetCount();
      for (int i = 0; i < 6; ++i) f_.octs[oct][i] = vertices[tables.octs[k][i]];
      for (int i = 0; i < 8; ++i) {
        f_.octFacets[oct][i] = childFacet(tables.octFacets[k][i], facets, firstInside);
      }
      f_.cellRegions[firstOct + k] = c_.cellRegions[cell];
    }
  }

  void splitTet(Index tet) {
    const auto& facets = c_.tetFacets[tet];
    Index vertices[10];
    for (int i = 0; i < 4; ++i) vertices[i] = c_.tets[tet][i];
    for (int k = 0; k < 6; ++k) vertices[4 + k] = children_.midpoint(c_.tetEdge(tet, k).index());
    const Index firstInside = children_.inTet(tet, 0), oct = children_.innerOct(tet);
    makeChildren<Tetrahedron>(facets, vertices, tet, children_.cornerTet(tet, 0), oct, firstInside);

    const auto& tables = SplitTables<Tetrahedron>::get();
    for (int f = 0; f < 4; ++f) {
      for (int k = 0; k < 3; ++k) {
        f_.facetEdges[firstInside + f][k] = cutEdgeRef(tables.insideCuts[f][k], facets);
      }
    }
    const int frame = c_.cellFrames[tet];
    for (int k = 0; k < 4; ++k) {
      f_.cellSigns[children_.cornerTet(tet, k)] = c_.cellSigns[tet];
      f_.cellFrames[children_.cornerTet(tet, k)] = c_.cellFrames[tet];
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
    for (int k = 0; k < 12; ++k) vertices[6 + k] = children_.midpoint(c_.octEdge(oct, k).index());
    const Index centre = children_.centre(oct);
    vertices[kCentreLabel] = centre;
    f_.vertexTypes[centre] = VertexType::R;
    const Index firstTet = children_.innerTet(oct, 0), firstOct = children_.cornerOct(oct, 0);
    const Index firstInside = children_.inOct(oct, 0), firstSpoke = children_.spoke(oct, 0);
    makeChildren<Octahedron>(facets, vertices, cell, firstTet, firstOct, firstInside);

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
      f_.cellSigns[firstOct + k] = c_.cellSigns[cell];
      f_.cellFrames[firstOct + k] = c_.cellFrames[cell];
    }
  }

  const Complex& c_;
  Complex& f_;
  const ChildNumbering children_;
};

}  // namespace

std::shared_ptr<const Complex> split(const std::shared_ptr<const Complex>& coarse) {
  const ChildNumbering children = coarse->children();
  if (children.edgeCount() >= EdgeRef::kMaxEdges || children.facetCount() >= FacetRef::kMaxFacets) {
    throw InputError("levels", "one more level would have " + std::to_string(children.cellCount()) +
                                   " cells, more than can be numbered");
  }
  auto fine = std::make_shared<Complex>();
  Splitter(coarse, fine.get()).run();
  return fine;
}

}  // namespace octet
