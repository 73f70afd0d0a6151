// SPDX-License-Identifier: Apache-2.0
#include "lattice_sites.h"

#include <algorithm>

#include "../base/parallel.h"

namespace octet {
namespace {

/// Class bits of a site's simplices: edges, then facets, then cells.
constexpr int kFacetBits = kEdgeClasses, kCellBits = kEdgeClasses + kFacetClasses;

/// The control cell that a cell descends from.
Index controlCell(const Complex& complex, Index cell) {
  const Complex* level = &complex;
  while (level->coarse) {
    level = level->coarse.get();
    cell = level->children().parentCell(cell);
  }
  return cell;
}

}  // namespace

LatticeSites::LatticeSites(const Complex& complex) {
  listSites(complex);
  if (count() == 0) {
    begin_ = {};
    entries_ = {};
    return;
  }
  fillTables(complex);
  findRegular(complex);
}

void LatticeSites::listSites(const Complex& complex) {
  const Index regionCount =
      complex.cellCount() == 0
          ? 0
          : *std::max_element(complex.cellRegions.begin(), complex.cellRegions.end()) + 1;
  std::vector<std::uint8_t> wanted(regionCount, 0);
  const auto anyCell = [&](Index v) {
    Index cell = kNone;
    complex.visitVertexStar(v, [&](const CellAtVertex& at) { cell = at.cell; });
    return cell;
  };
  parallelFor<Index>(complex.vertexCount(), [&](Index v) {
    if (complex.vertexTypes[v] == VertexType::R) {
      storeRelaxed<std::uint8_t>(&wanted[complex.cellRegions[anyCell(v)]], 1);
    }
  });

  // Regions at a vertex, each once, with one of their cells.
  const auto collect = [&](Index v, std::vector<Entry>* entries) {
    entries->clear();
    if (complex.vertexTypes[v] == VertexType::R) {
      const Index cell = anyCell(v);
      entries->push_back({complex.cellRegions[cell], cell});
      return;
    }
    complex.visitVertexStar(v, [&](const CellAtVertex& at) {
      const Index r = complex.cellRegions[at.cell];
      const bool isNew = std::none_of(entries->begin(), entries->end(),
                                      [&](const Entry& e) { return e.region == r; });
      if (wanted[r] && isNew) entries->push_back({r, at.cell});
    });
  };
  begin_.assign(complex.vertexCount() + 1, 0);
  parallelRanges<Index>(complex.vertexCount(), [&](Index first, Index last) {
    std::vector<Entry> entries;
    for (Index v = first; v != last; ++v) {
      collect(v, &entries);
      begin_[v + 1] = static_cast<Index>(entries.size());
    }
  });
  for (std::size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  const Index siteCount = begin_.back();
  entries_.resize(siteCount);
  vertices.resize(siteCount);
  if (siteCount == 0) return;

  // Sites of one control cell are numbered together: then smoothing runs in cache.
  Array<Index> keys(siteCount);
  parallelRanges<Index>(complex.vertexCount(), [&](Index first, Index last) {
    std::vector<Entry> entries;
    for (Index v = first; v != last; ++v) {
      collect(v, &entries);
      for (std::size_t k = 0; k < entries.size(); ++k) {
        keys[begin_[v] + k] = controlCell(complex, entries[k].site);
        entries_[begin_[v] + k] = entries[k];
      }
    }
  });
  const Index keyCount = *std::max_element(keys.begin(), keys.end()) + 1;
  Array<Index> next(keyCount + 1, 0);
  for (const Index key : keys) ++next[key + 1];
  for (Index k = 0; k < keyCount; ++k) next[k + 1] += next[k];
  for (Index v = 0; v < complex.vertexCount(); ++v) {
    for (Index k = begin_[v]; k < begin_[v + 1]; ++k) {
      entries_[k].site = next[keys[k]]++;
      vertices[entries_[k].site] = v;
    }
  }
}

Index LatticeSites::siteAt(Index vertex, Index region) const {
  for (Index k = begin_[vertex]; k < begin_[vertex + 1]; ++k) {
    if (entries_[k].region == region) return entries_[k].site;
  }
  return kNone;
}

void LatticeSites::fillTables(const Complex& complex) {
  neighbours.resize(count());
  edges.resize(count());
  facets.resize(count());
  cells.resize(count());
  handedness.resize(count());
  parallelFor<Index>(count(), [&](Index s) { neighbours[s].fill(kNone); });
  const Lattice& lattice = Lattice::get();

  // Cells that share a simplex all store the same reference to it.
  const auto tell = [&](Index cell, const auto& placement, auto shape) {
    using Shape = decltype(shape);
    const Index region = complex.cellRegions[cell];
    const auto handed = static_cast<std::int8_t>(complex.cellSigns[cell] * placement.cell.sign);
    Index sites[Shape::kVertices];
    for (int i = 0; i < Shape::kVertices; ++i) {
      sites[i] = siteAt(complex.cellVertex(cell, i), region);
      if (sites[i] == kNone) return;  // a region without sites has none at all
    }
    for (int i = 0; i < Shape::kVertices; ++i) {
      storeRelaxed(&handedness[sites[i]], handed);
      for (int j = 0; j < Shape::kVertices; ++j) {
        if (j != i) storeRelaxed(&neighbours[sites[i]][placement.neighbour[i][j]], sites[j]);
      }
    }
    for (int k = 0; k < Shape::kEdges; ++k) {
      const LatticeSlot& slot = placement.edges[k];
      const EdgeRef e = complex.cellEdge(cell, Shape::edges[k][0], Shape::edges[k][1]);
      edges[sites[slot.base]][slot.simplexClass].store(
          LatticeRef(e.index(), (slot.sign < 0) != e.reversed()));
    }
    for (int k = 0; k < Shape::kFacets; ++k) {
      const LatticeSlot& slot = placement.facets[k];
      const FacetRef f = complex.cellFacet(cell, k);
      facets[sites[slot.base]][slot.simplexClass].store(
          LatticeRef(f.index(), slot.sign * f.sign() < 0));
    }
    cells[sites[placement.cell.base]][placement.cell.simplexClass] = LatticeRef(cell, false);
  };
  parallelFor<Index>(complex.cellCount(), [&](Index cell) {
    const int frame = complex.cellFrames[cell];
    if (complex.isTet(cell)) {
      tell(cell, lattice.tetPlacements[frame], Tetrahedron{});
    } else {
      tell(cell, lattice.octPlacements[frame], Octahedron{});
    }
  });
}

void LatticeSites::findRegular(const Complex& complex) {
  regularEdges.assign(count(), 0);
  regularFacets.assign(count(), 0);
  regularCells.assign(count(), 0);
  const Lattice& lattice = Lattice::get();
  const auto isR = [&](Index s) { return complex.vertexTypes[vertices[s]] == VertexType::R; };

  Array<std::uint32_t> exists(count());
  parallelFor<Index>(count(), [&](Index s) {
    std::uint32_t bits = 0;
    for (int c = 0; c < kEdgeClasses; ++c) bits |= std::uint32_t{edges[s][c].exists()} << c;
    for (int c = 0; c < kFacetClasses; ++c) {
      bits |= std::uint32_t{facets[s][c].exists()} << (kFacetBits + c);
    }
    for (int c = 0; c < kCellClasses; ++c) {
      bits |= std::uint32_t{cells[s][c].exists()} << (kCellBits + c);
    }
    exists[s] = bits;
  });
  // Classes whose 19 translates exist: based at the site and at all its neighbours.
  Array<std::uint32_t> translates(count());
  parallelFor<Index>(count(), [&](Index s) {
    translates[s] = 0;
    if (!isR(s)) return;
    std::uint32_t bits = exists[s];
    for (const Index n : neighbours[s]) bits &= exists[n];
    translates[s] = bits;
  });
  // The terms of a homotopy row that R vertices do not guarantee.
  const auto termsExist = [&](int firstBit, Index s, const std::vector<LatticeTerm>& terms) {
    return std::all_of(terms.begin(), terms.end(), [&](const LatticeTerm& term) {
      if (term.certain) return true;
      const Index at = siteOf(s, term);
      return at != kNone && (exists[at] >> (firstBit + term.simplexClass) & 1u);
    });
  };
  // A simplex is regular only if its boundary is: both sides of d then use the same rows.
  parallelFor<Index>(count(), [&](Index s) {
    for (int c = 0; c < kEdgeClasses; ++c) {
      if ((translates[s] >> c & 1u) && isR(neighbours[s][lattice.edgeEnd[c]]) &&
          termsExist(kFacetBits, s, lattice.edgeHomotopy[c])) {
        regularEdges[s] |= static_cast<std::uint8_t>(1u << c);
      }
    }
  });
  parallelFor<Index>(count(), [&](Index s) {
    for (int c = 0; c < kFacetClasses; ++c) {
      if (!(translates[s] >> (kFacetBits + c) & 1u)) continue;
      const auto& boundary = lattice.facetBoundary[c];
      const bool edgesRegular =
          std::all_of(boundary.begin(), boundary.end(), [&](const LatticeTerm& term) {
            return regularEdges[siteOf(s, term)] >> term.simplexClass & 1;
          });
      if (edgesRegular && termsExist(kCellBits, s, lattice.facetHomotopy[c])) {
        regularFacets[s] |= static_cast<std::uint8_t>(1u << c);
      }
    }
  });
  parallelFor<Index>(count(), [&](Index s) {
    for (int c = 0; c < kCellClasses; ++c) {
      if (!(translates[s] >> (kCellBits + c) & 1u)) continue;
      const auto& boundary = lattice.cellBoundary[c];
      const bool facetsRegular =
          std::all_of(boundary.begin(), boundary.end(), [&](const LatticeTerm& term) {
            return regularFacets[siteOf(s, term)] >> term.simplexClass & 1;
          });
      if (facetsRegular) regularCells[s] |= static_cast<std::uint8_t>(1u << c);
    }
  });
}

}  // namespace octet
