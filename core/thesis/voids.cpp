// SPDX-License-Identifier: Apache-2.0
#include "voids.h"

#include <algorithm>

namespace octet {

class Voids::Builder {
 public:
  Builder(const Complex& mesh, const Complex& expanded, const std::vector<Index>& cells, Voids* out)
      : c_(mesh), e_(expanded), out_(*out) {
    findPieces();
    listed_.assign(static_cast<std::size_t>(c_.cellCount()), 0);
    reached_.assign(static_cast<std::size_t>(c_.cellCount()), Step{kNone, kNone});
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      if (!listed_[static_cast<std::size_t>(cell)]) findVoids(part(cell));
    }
    findExits(cells);
  }

 private:
  /// How a cell was reached: through which facet, from which cell (none: from the outside).
  struct Step {
    Index facet, from;
  };

  static double outward(const Complex& c, Index cell, Index facet) {
    const bool first = c.facetCells[facet][0].exists() && c.facetCells[facet][0].cell() == cell;
    return first ? 1.0 : -1.0;
  }
  /// Calls visit(facet, cell beyond or kNone) around a cell.
  template <typename Visit>
  static void visitNeighbours(const Complex& c, Index cell, const Visit& visit) {
    for (int k = 0; k < c.cellFacetCount(cell); ++k) {
      const Index facet = c.cellFacet(cell, k).index();
      Index beyond = kNone;
      for (const CellSide& side : c.facetCells[facet]) {
        if (side.exists() && side.cell() != cell) beyond = side.cell();
      }
      visit(facet, beyond);
    }
  }

  /// Pieces of the boundary, joined at edges where it does not touch itself.
  void findPieces() {
    std::map<Index, std::vector<Index>> atEdge;
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      for (const EdgeRef& e : c_.facetEdges[f]) atEdge[e.index()].push_back(f);
    }
    piece_.assign(static_cast<std::size_t>(c_.facetCount()), kNone);
    for (Index seed = 0; seed < c_.facetCount(); ++seed) {
      if (!c_.facetOnBoundary(seed) || pieceOf(seed) != kNone) continue;
      std::vector<Index> queue = {seed};
      pieceOf(seed) = seed;
      for (std::size_t k = 0; k < queue.size(); ++k) {
        for (const EdgeRef& e : c_.facetEdges[queue[k]]) {
          const auto& there = atEdge.at(e.index());
          if (there.size() > 2) continue;
          for (const Index f : there) {
            if (pieceOf(f) != kNone) continue;
            pieceOf(f) = seed;
            queue.push_back(f);
          }
        }
      }
    }
  }
  Index& pieceOf(Index facet) { return piece_[static_cast<std::size_t>(facet)]; }

  /// The cells that hang together with one by facets.
  std::vector<Index> part(Index seed) {
    std::vector<Index> result = {seed};
    listed_[static_cast<std::size_t>(seed)] = 1;
    for (std::size_t k = 0; k < result.size(); ++k) {
      visitNeighbours(c_, result[k], [&](Index, Index beyond) {
        if (beyond == kNone || listed_[static_cast<std::size_t>(beyond)]) return;
        listed_[static_cast<std::size_t>(beyond)] = 1;
        result.push_back(beyond);
      });
    }
    return result;
  }

  /// All pieces of a part's boundary but the largest are voids.
  void findVoids(const std::vector<Index>& cells) {
    std::map<Index, std::vector<std::pair<Index, Index>>> walls;  // piece: facets and cells
    for (const Index cell : cells) {
      visitNeighbours(c_, cell, [&](Index facet, Index beyond) {
        if (beyond == kNone) walls[pieceOf(facet)].emplace_back(facet, cell);
      });
    }
    const auto outside = std::max_element(
        walls.begin(), walls.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    flowFrom(outside->second.front());
    for (const auto& [piece, wall] : walls) {
      if (piece == outside->first) continue;
      SparseChain surface;
      for (const auto& [facet, cell] : wall) {
        surface.emplace_back(facet, outward(c_, cell, facet));
      }
      leadTo(wall.front(), static_cast<int>(out_.surfaces_.size()));
      out_.surfaces_.push_back(std::move(surface));
    }
  }

  /// Reaches all cells from a boundary facet of one.
  void flowFrom(const std::pair<Index, Index>& source) {
    reached_[static_cast<std::size_t>(source.second)] = {source.first, kNone};
    std::vector<Index> queue = {source.second};
    for (std::size_t k = 0; k < queue.size(); ++k) {
      visitNeighbours(c_, queue[k], [&](Index facet, Index beyond) {
        if (beyond == kNone) return;
        Step& step = reached_[static_cast<std::size_t>(beyond)];
        if (step.facet != kNone) return;
        step = {facet, queue[k]};
        queue.push_back(beyond);
      });
    }
  }

  /// The flow of a void, back from a facet of its surface to where it enters the mesh.
  void leadTo(const std::pair<Index, Index>& target, int which) {
    out_.flows_[target.first].emplace_back(which, outward(c_, target.second, target.first));
    for (Index cell = target.second; cell != kNone;) {
      const Step& step = reached_[static_cast<std::size_t>(cell)];
      out_.flows_[step.facet].emplace_back(which, -outward(c_, cell, step.facet));
      cell = step.from;
    }
  }

  void findExits(const std::vector<Index>& realCells) {
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(e_.cellCount()), 0);
    for (const Index cell : realCells) seen[static_cast<std::size_t>(cell)] = 1;
    auto& exits = out_.exits_;
    const auto leave = [&](Index cell, Index facet) {
      if (seen[static_cast<std::size_t>(cell)]) return;
      seen[static_cast<std::size_t>(cell)] = 1;
      exits.push_back({cell, facet});
    };
    for (Index cell = 0; cell < e_.cellCount(); ++cell) {
      visitNeighbours(e_, cell, [&](Index facet, Index beyond) {
        if (beyond == kNone) leave(cell, facet);
      });
    }
    for (std::size_t k = 0; k < exits.size(); ++k) {
      visitNeighbours(e_, exits[k].cell, [&](Index facet, Index beyond) {
        if (beyond != kNone) leave(beyond, facet);
      });
    }
    std::reverse(exits.begin(), exits.end());
  }

  const Complex &c_, &e_;
  Voids& out_;
  std::vector<Index> piece_;          // of the boundary, by facet
  std::vector<std::uint8_t> listed_;  // cells of parts that were looked at
  std::vector<Step> reached_;
};

Voids::Voids(const Complex& mesh, const Complex& expanded, const std::vector<Index>& cells) {
  Builder(mesh, expanded, cells, this);
}

std::vector<double> Voids::windings(const std::map<Index, double>& chain) const {
  std::vector<double> result(surfaces_.size(), 0.0);
  for (const auto& [facet, weight] : chain) {
    const auto flows = flows_.find(facet);
    if (flows == flows_.end()) continue;
    for (const auto& [which, flow] : flows->second) {
      result[static_cast<std::size_t>(which)] += weight * flow;
    }
  }
  return result;
}

}  // namespace octet
