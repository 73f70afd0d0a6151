// SPDX-License-Identifier: Apache-2.0
#include "lattice_regions.h"

#include <algorithm>
#include <array>

#include "../rules/lattice.h"

namespace octet {
namespace {

/// A cell's lattice points, by local vertex; a tetrahedron uses four.
using CellPoints = std::array<Int3, 6>;

class RegionFinder {
 public:
  explicit RegionFinder(Complex* complex)
      : complex_(*complex),
        frames_(complex->cellCount(), 0),
        points_(complex->cellCount()),
        vertexPoint_(complex->vertexCount()),
        vertexStamp_(complex->vertexCount(), kNone) {
    complex_.cellRegions.assign(complex_.cellCount(), kNone);
  }

  void run() {
    Array<Index> members;
    for (Index start = 0; start < complex_.cellCount(); ++start) {
      if (complex_.cellRegions[start] != kNone) continue;
      if (grow(start, &members)) {
        assign(members);
      } else {
        for (const Index cell : members) assignAlone(cell);
      }
    }
    complex_.cellFrames.assign(frames_.begin(), frames_.end());
  }

 private:
  /// Breadth-first over a component, giving each cell its points. `members` is the whole component
  /// even when it does not close up.
  bool grow(Index start, Array<Index>* members) {
    members->assign(1, start);
    setOwnPoints(start);
    ++stamp_;
    seen_.resize(complex_.cellCount(), kNone);
    seen_[start] = stamp_;
    bool closes = record(start);
    Array<std::pair<Int3, Index>> used;
    for (std::size_t k = 0; k < members->size(); ++k) {
      const Index a = (*members)[k];
      visitNeighbours(a, [&](Index b, int side, int otherSide) {
        if (seen_[b] == stamp_) return;
        seen_[b] = stamp_;
        members->push_back(b);
        if (!closes) return;
        placeAcross(a, side, b, otherSide);
        closes = record(b);
      });
    }
    if (!closes) return false;
    // One vertex per point: sort the component's vertices by their points.
    for (const Index c : *members) {
      for (int i = 0; i < complex_.cellVertexCount(c); ++i) {
        used.emplace_back(points_[c][i], complex_.cellVertex(c, i));
      }
    }
    std::sort(used.begin(), used.end());
    for (std::size_t k = 1; k < used.size(); ++k) {
      if (used[k].first == used[k - 1].first && used[k].second != used[k - 1].second) return false;
    }
    return true;
  }

  void assign(const Array<Index>& members) {
    for (const Index c : members) complex_.cellRegions[c] = regionCount_;
    ++regionCount_;
  }
  void assignAlone(Index cell) {
    setOwnPoints(cell);
    complex_.cellRegions[cell] = regionCount_++;
  }

  /// Calls visit(neighbour, local facet of the cell, local facet of the neighbour) across every
  /// tetrahedron|octahedron facet.
  template <typename Visit>
  void visitNeighbours(Index cell, const Visit& visit) const {
    for (int f = 0; f < complex_.cellFacetCount(cell); ++f) {
      const auto& sides = complex_.facetCells[complex_.cellFacet(cell, f).index()];
      if (!sides[0].exists() || !sides[1].exists()) continue;
      const CellSide& other = sides[sides[0].cell() == cell ? 1 : 0];
      if (complex_.isTet(other.cell()) != complex_.isTet(cell)) {
        visit(other.cell(), f, other.facet());
      }
    }
  }

  void setOwnPoints(Index cell) {
    frames_[cell] = 0;  // symmetry 0 is the identity
    const bool tet = complex_.isTet(cell);
    for (int i = 0; i < complex_.cellVertexCount(cell); ++i) {
      points_[cell][i] = tet ? canonicalPoints<Tetrahedron>()[i] : canonicalPoints<Octahedron>()[i];
    }
  }

  /// Puts cell b beside cell a: their shared vertices have one place in the lattice.
  void placeAcross(Index a, int side, Index b, int otherSide) {
    if (complex_.isTet(b)) {
      placeShape<Tetrahedron>(a, complex_.isTet(a) ? nullptr : Octahedron::facets[side], b,
                              Tetrahedron::facets[otherSide]);
    } else {
      placeShape<Octahedron>(a, Tetrahedron::facets[side], b, Octahedron::facets[otherSide]);
    }
  }

  template <typename Shape>
  void placeShape(Index a, const std::uint8_t* sideOfA, Index b, const std::uint8_t* sideOfB) {
    std::array<int, 3> local;
    std::array<Int3, 3> at;
    for (int k = 0; k < 3; ++k) {
      local[k] = sideOfB[k];
      for (int j = 0; j < 3; ++j) {
        if (complex_.cellVertex(a, sideOfA[j]) == complex_.cellVertex(b, sideOfB[k])) {
          at[k] = points_[a][sideOfA[j]];
        }
      }
    }
    std::array<Int3, Shape::kVertices> points;
    Lattice::get().place<Shape>(local, at, &frames_[b], &points);
    std::copy(points.begin(), points.end(), points_[b].begin());
  }

  /// Notes a cell's vertices; false when one has another point already.
  bool record(Index cell) {
    for (int i = 0; i < complex_.cellVertexCount(cell); ++i) {
      const Index v = complex_.cellVertex(cell, i);
      if (vertexStamp_[v] == stamp_ && vertexPoint_[v] != points_[cell][i]) return false;
      vertexStamp_[v] = stamp_;
      vertexPoint_[v] = points_[cell][i];
    }
    return true;
  }

  Complex& complex_;
  Array<int> frames_;
  Array<CellPoints> points_;
  Array<Int3> vertexPoint_;
  Array<Index> vertexStamp_;
  Array<Index> seen_;
  Index stamp_ = 0;
  Index regionCount_ = 0;
};

}  // namespace

void findLatticeRegions(Complex* complex) { RegionFinder(complex).run(); }

}  // namespace octet
