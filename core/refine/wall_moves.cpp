// SPDX-License-Identifier: Apache-2.0
#include "wall_moves.h"

#include <algorithm>
#include <optional>

#include "../base/parallel.h"
#include "../rules/wall_rules.h"
#include "../topology/star_walk.h"
#include "solved_stars.h"

namespace octet {
namespace {

/// @brief A wall star as it lies in the mesh.
struct LabelledWallStar {
  std::vector<Index> vertices;
  WallStar wall;
};

/// @brief The ring of a boundary vertex, from which its star is labelled.
class WallRing {
 public:
  WallRing(const Complex& complex, const Boundary& boundary, Index row)
      : c_(complex), boundary_(boundary), row_(row), centre_(boundary.vertices[row]) {}

  /// Is the wall around the vertex one closed ring of facets?
  bool closes() const {
    const RingStep* const begin = boundary_.ringBegin(row_);
    const auto n = static_cast<Index>(boundary_.ringEnd(row_) - begin);
    if (n < 3 || boundary_.valence(row_) != n) return false;
    for (Index k = 0; k < n; ++k) {
      const Index next = begin[(k + 1) % n].edge.index();
      const auto& edges = c_.facetEdges[begin[k].facet];
      if (std::none_of(edges.begin(), edges.end(),
                       [&](const EdgeRef& e) { return e.index() == next; })) {
        return false;
      }
    }
    return true;
  }

  /// Is the star that of a lattice cut along a plane? Then there is nothing to move.
  bool regular() const {
    if (!boundary_.regular(row_)) return false;
    int tets = 0, octs = 0;
    c_.visitVertexStar(centre_,
                       [&](const CellAtVertex& at) { ++(c_.isTet(at.cell) ? tets : octs); });
    if (tets != 4 || octs != 3) return false;
    return std::all_of(boundary_.ringBegin(row_), boundary_.ringEnd(row_),
                       [&](const RingStep& step) {
                         int tetsAtEdge = 0, octsAtEdge = 0;
                         c_.visitEdgeStar(step.edge.index(), [&](const CellAtEdge& at) {
                           ++(c_.isTet(at.cell) ? tetsAtEdge : octsAtEdge);
                         });
                         return tetsAtEdge == 1 && octsAtEdge == 1;
                       });
  }

  /// The least of the labellings, over all beginnings and both directions.
  std::optional<LabelledWallStar> canonical() const {
    std::optional<LabelledWallStar> best;
    for (int start = 0; start < boundary_.valence(row_); ++start) {
      for (const int turn : {1, -1}) {
        std::optional<LabelledWallStar> candidate = label(start, turn);
        if (!candidate) return std::nullopt;
        if (!best || candidate->wall < best->wall) best = std::move(candidate);
      }
    }
    return best;
  }

 private:
  std::optional<LabelledWallStar> label(int start, int turn) const {
    const RingStep* const ring = boundary_.ringBegin(row_);
    const int n = boundary_.valence(row_);
    LabelledWallStar result;
    result.wall.valence = n;
    std::vector<Index> first, cells;
    for (int k = 0; k < n; ++k) {
      const EdgeRef edge = ring[((start + turn * k) % n + n) % n].edge;
      first.push_back(c_.edges[edge.index()][edge.reversed() ? 0 : 1]);
      // The facet that follows the edge in the direction of the walk.
      const int at = turn > 0 ? start + k : start - k - 1;
      const auto& sides = c_.facetCells[ring[(at % n + n) % n].facet];
      cells.push_back((sides[0].exists() ? sides[0] : sides[1]).cell());
    }
    std::optional<LabelledStar> star = walkStar(c_, centre_, first, cells);
    if (!star) return std::nullopt;
    result.vertices = std::move(star->vertices);
    result.wall.star = std::move(star->star);
    return result;
  }

  const Complex& c_;
  const Boundary& boundary_;
  Index row_, centre_;
};

/// What one boundary vertex asks of the children around it; rows may be claimed by others too.
StarMoves claims(const Complex& coarse, const Boundary& boundary, Index row) {
  if (boundary.kinds[row] != BoundaryKind::Smooth) return {};
  const WallRing ring(coarse, boundary, row);
  if (!ring.closes() || ring.regular()) return {};
  const std::optional<LabelledWallStar> labelled = ring.canonical();
  if (!labelled) return {};
  const WallStar& wall = labelled->wall;
  const StarPaths paths(coarse, labelled->vertices);
  if (!paths.unique()) return {};
  static SolvedStars<WallStar, Eigen::MatrixXd> solved(wallStarMoves);
  const std::shared_ptr<const Eigen::MatrixXd> moves = solved(wall);
  StarMoves result;
  result.atWall = true;
  for (int a = 0; a < wall.star.vertexCount; ++a) {
    // A child on the way to another part of the wall belongs to both, and stays.
    if (a > wall.valence && coarse.vertexOnBoundary(labelled->vertices[a])) continue;
    result.add(paths, a, moves->row(a));
  }
  return result;
}

}  // namespace

void wallMoves(const Complex& coarse, const Boundary& boundary, std::vector<StarMoves>* stars) {
  std::vector<StarMoves> claimed(static_cast<std::size_t>(boundary.vertexCount()));
  parallelFor<std::size_t>(
      claimed.size(),
      [&](std::size_t row) { claimed[row] = claims(coarse, boundary, static_cast<Index>(row)); },
      16);
  for (StarMoves& moves : claimed) {
    if (!moves.children.empty()) stars->push_back(std::move(moves));
  }
}

}  // namespace octet
