// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/parallel.h"
#include "../rules/lattice.h"
#include "complex.h"

namespace octet {

/// A coefficient seen along its lattice class' orientation; 4 bytes.
class LatticeRef {
 public:
  LatticeRef() = default;
  LatticeRef(Index index, bool reversed)
      : code_(static_cast<std::uint32_t>(index) << 1 | reversed) {}
  bool exists() const { return code_ != kMissing; }
  Index index() const { return static_cast<Index>(code_ >> 1); }
  double sign() const { return code_ & 1u ? -1.0 : 1.0; }
  /// Stores a value that several threads may store at once, all the same.
  void store(LatticeRef other) { storeRelaxed(&code_, other.code_); }

 private:
  static constexpr std::uint32_t kMissing = 0xffffffffu;
  std::uint32_t code_ = kMissing;
};

/// @brief The lattice structure of one level: a site for every vertex in every lattice region at
/// it, with the site's lattice neighbours and the simplices based there, and which of these are
/// regular. A simplex is regular when all its vertices are of type R and its 19 translates exist in
/// the region (SCHEME.md section 6); then smoothing is the average over translates.
///
/// Regions without a regular vertex at this level get no sites.
class LatticeSites {
 public:
  LatticeSites() = default;
  explicit LatticeSites(const Complex& complex);

  Index count() const { return static_cast<Index>(vertices.size()); }

  /// The site of a vertex of type R, which lies in one region only; kNone for other vertices.
  Index siteOfRegular(const Complex& complex, Index vertex) const {
    return count() && complex.vertexTypes[vertex] == VertexType::R ? entries_[begin_[vertex]].site
                                                                   : kNone;
  }

  /// Site reached from a site by one hop (kSelf stays), or kNone.
  Index hop(Index site, std::uint8_t k) const { return k == kSelf ? site : neighbours[site][k]; }
  /// Site at which a chain's term is based; its hops exist around a regular site.
  Index siteOf(Index base, const LatticeTerm& term) const {
    const Index via = hop(base, term.hops[0]);
    return via == kNone ? kNone : hop(via, term.hops[1]);
  }

  /// Calls `visit(site, class, weight)` for a lattice chain's terms, seen from a regular site.
  template <typename Visit>
  void visitChain(Index site, const std::vector<LatticeTerm>& chain, const Visit& visit) const {
    for (const LatticeTerm& term : chain) visit(siteOf(site, term), term.simplexClass, term.weight);
  }

  Array<Index> vertices;  ///< of each site
  Array<std::array<Index, kNeighbours>> neighbours;
  Array<std::array<LatticeRef, kEdgeClasses>> edges;
  Array<std::array<LatticeRef, kFacetClasses>> facets;
  Array<std::array<LatticeRef, kCellClasses>> cells;
  /// Which classes of edges, facets and cells based here are regular: bit c for class c.
  Array<std::uint8_t> regularEdges, regularFacets, regularCells;
  /// +1 when the region's lattice coordinates have the orientation of space, else -1.
  Array<std::int8_t> handedness;

 private:
  void listSites(const Complex& complex);
  void fillTables(const Complex& complex);
  void findRegular(const Complex& complex);
  Index siteAt(Index vertex, Index region) const;

  /// A region at a vertex and the site there.
  struct Entry {
    Index region, site;
  };
  Array<Index> begin_;  // first entry of each vertex
  Array<Entry> entries_;
};

}  // namespace octet
