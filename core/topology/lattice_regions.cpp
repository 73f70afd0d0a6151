// SPDX-License-Identifier: Apache-2.0
#include "lattice_regions.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

#include "../rules/lattice.h"

namespace octet {
namespace {

/// A cell's lattice points, by local vertex; a tetrahedron uses four.
using CellPoints = std::array<Int3, 6>;

struct PointHash {
  std::size_t operator()(const Int3& p) const {
    std::uint64_t h = 0;
    for (const int x : p) h = (h ^ static_cast<std::uint32_t>(x)) * 0x9e3779b97f4a7c15ull;
    return static_cast<std::size_t>(h >> 16 ^ h);
  }
};

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
      if (grow(start, 0, &members)) {
        assign(members);
      } else {
        splitComponent(members);
      }
    }
    complex_.cellFrames.assign(frames_.begin(), frames_.end());
  }

 private:
  /// Breadth-first over unassigned cells of index >= `first`, giving each its points. `members` is
  /// the whole component even when it does not close up.
  bool grow(Index start, Index first, Array<Index>* members) {
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
        if (b < first || seen_[b] == stamp_ || complex_.cellRegions[b] != kNone) return;
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

  /// A component that does not close up. Adding its cells from the last to the first with a
  /// union-find that carries lattice coordinates tells, for each cell, whether the component of the
  /// cells from it on closes up.
  void splitComponent(Array<Index> members) {
    std::sort(members.begin(), members.end());
    Array<char> closesFrom(members.size());
    Joiner joiner(*this);
    for (std::size_t k = members.size(); k-- > 0;) closesFrom[k] = joiner.add(members[k]);
    Array<Index> region;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Index start = members[k];
      if (complex_.cellRegions[start] != kNone) continue;
      if (closesFrom[k]) {
        grow(start, start, &region);
      } else {
        setOwnPoints(start);
        region.assign(1, start);
      }
      assign(region);
    }
  }

  class Joiner {
   public:
    explicit Joiner(RegionFinder& finder) : finder_(finder) {}

    /// Adds a cell and joins it to its neighbours that are there already.
    bool add(Index cell) {
      Index root = cell;
      finder_.setOwnPoints(cell);
      parts_[cell].cells = {cell};
      rootOf_[cell] = cell;
      bool closes = insertVertices(&parts_[cell], cell);
      parts_[cell].closes = closes;
      finder_.visitNeighbours(cell, [&](Index b, int side, int otherSide) {
        const auto found = rootOf_.find(b);
        if (found == rootOf_.end()) return;
        const Index other = found->second;
        if (other == root) return;
        root = parts_[root].cells.size() >= parts_[other].cells.size()
                   ? join(root, other, cell, side, b, otherSide)
                   : join(other, root, b, otherSide, cell, side);
      });
      return parts_[root].closes;
    }

   private:
    struct Part {
      Array<Index> cells;
      std::unordered_map<Index, Int3> pointOf;
      std::unordered_map<Int3, Index, PointHash> vertexAt;
      bool closes = true;
    };

    bool insertVertices(Part* part, Index cell) {
      const Complex& complex = finder_.complex_;
      for (int i = 0; i < complex.cellVertexCount(cell); ++i) {
        const Index v = complex.cellVertex(cell, i);
        const Int3& p = finder_.points_[cell][i];
        if (part->pointOf.emplace(v, p).first->second != p) return false;
        if (part->vertexAt.emplace(p, v).first->second != v) return false;
      }
      return true;
    }

    /// Moves part `from` into part `into`, b of `from` being beside a of `into`.
    Index join(Index into, Index from, Index a, int side, Index b, int otherSide) {
      Part& target = parts_[into];
      Part& source = parts_[from];
      target.closes = target.closes && source.closes;
      // The motion that takes b from where it is to where a wants it: the same for all its part.
      const int frameBefore = finder_.frames_[b];
      const Int3 before = finder_.points_[b][0];
      finder_.placeAcross(a, side, b, otherSide);
      const int turn = finder_.quotient(finder_.frames_[b], frameBefore);
      const Int3 after = finder_.points_[b][0];
      const Lattice& lattice = Lattice::get();
      for (const Index c : source.cells) {
        rootOf_[c] = into;
        target.cells.push_back(c);
        if (!target.closes) continue;
        if (c != b) {
          finder_.frames_[c] = lattice.compose(turn, finder_.frames_[c]);
          for (int i = 0; i < finder_.complex_.cellVertexCount(c); ++i) {
            Int3& p = finder_.points_[c][i];
            const Int3 moved =
                lattice.rotate(turn, {p[0] - before[0], p[1] - before[1], p[2] - before[2]});
            p = {moved[0] + after[0], moved[1] + after[1], moved[2] + after[2]};
          }
        }
        target.closes = insertVertices(&target, c);
      }
      if (!target.closes) {
        target.pointOf.clear();
        target.vertexAt.clear();
      }
      parts_.erase(from);
      return into;
    }

    RegionFinder& finder_;
    std::unordered_map<Index, Index> rootOf_;
    std::unordered_map<Index, Part> parts_;
  };

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

  /// The symmetry q with q inner = outer.
  int quotient(int outer, int inner) const {
    const Lattice& lattice = Lattice::get();
    int q = 0;
    while (lattice.compose(q, inner) != outer) ++q;
    return q;
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
