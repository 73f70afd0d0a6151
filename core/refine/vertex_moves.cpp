// SPDX-License-Identifier: Apache-2.0
#include "vertex_moves.h"

#include <algorithm>
#include <tuple>

#include "../base/parallel.h"
#include "../topology/control_mesh.h"

namespace octet {
namespace {

/// The least share of its volume that a cell keeps, at walls and inside.
constexpr double kLeastAtWalls = 0.6, kLeastInside = 0.25;
/// Stars inside are only looked at in so many splits: later they are apart.
constexpr int kOverlapping = 3;
/// Stars are left out in so many rounds, each of which may part others.
constexpr int kRounds = 8;

/// Puts rows in order and adds what one coarse edge has in a row, by size: sums then depend on
/// nothing but what is added.
void merge(std::vector<VertexMove>* moves) {
  const auto row = [](const VertexMove& m) { return std::pair(m.fineVertex, m.coarseEdge); };
  const auto signless = [](const VertexMove& m) { return std::abs(m.weight); };
  std::sort(moves->begin(), moves->end(), [&](const VertexMove& a, const VertexMove& b) {
    return std::tuple(row(a), signless(a), a.weight) < std::tuple(row(b), signless(b), b.weight);
  });
  std::size_t kept = 0;
  for (const VertexMove& move : *moves) {
    if (kept > 0 && row((*moves)[kept - 1]) == row(move)) {
      (*moves)[kept - 1].weight += move.weight;
    } else {
      (*moves)[kept++] = move;
    }
  }
  moves->resize(kept);
}

/// Calls `visit(child)` for the children that a star moves.
template <typename Visit>
void visitChildren(const StarMoves& star, const Visit& visit) {
  Index last = kNone;
  for (const VertexMove& move : star.moves) {
    if (move.fineVertex != last) visit(move.fineVertex);
    last = move.fineVertex;
  }
}

/// Does a star move a cell's vertices so that the cell is spoilt?
bool spoils(const StarMoves& star, const Complex& fine, const Array<Vec3>& unmoved,
            const Array<Vec3>& moved) {
  const double least = star.atWall ? kLeastAtWalls : kLeastInside;
  bool result = false;
  visitChildren(star, [&](Index child) {
    fine.visitVertexStar(child, [&](const CellAtVertex& at) {
      const double sign = fine.cellSigns[at.cell];
      const double without = sign * cellVolume6(fine, unmoved, at.cell);
      const double with = sign * cellVolume6(fine, moved, at.cell);
      if (without <= 0 || with < least * without) result = true;
    });
  });
  return result;
}

}  // namespace

LocalRows moveRows(const std::vector<StarMoves>& stars) {
  std::vector<Index> atWalls;  // a child once for each star that moves it
  for (const StarMoves& star : stars) {
    if (star.atWall) visitChildren(star, [&](Index child) { atWalls.push_back(child); });
  }
  std::sort(atWalls.begin(), atWalls.end());
  std::vector<VertexMove> moves;
  for (const StarMoves& star : stars) {
    for (VertexMove move : star.moves) {
      if (star.atWall) {
        const auto [first, last] =
            std::equal_range(atWalls.begin(), atWalls.end(), move.fineVertex);
        move.weight /= static_cast<double>(last - first);
      }
      moves.push_back(move);
    }
  }
  merge(&moves);
  std::vector<Index> fine;
  std::vector<std::size_t> begin;
  for (std::size_t k = 0; k < moves.size(); ++k) {
    if (!fine.empty() && moves[k].fineVertex == fine.back()) continue;
    fine.push_back(moves[k].fineVertex);
    begin.push_back(k);
  }
  begin.push_back(moves.size());
  return LocalRows(fine, [&](Index row, const auto& add) {
    for (std::size_t k = begin[row]; k < begin[row + 1]; ++k) {
      add(moves[k].coarseEdge, moves[k].weight);
    }
  });
}

std::vector<StarMoves> soundMoves(const Complex& fine, int level, const Array<Vec3>& before,
                                  std::vector<StarMoves> stars, Array<Vec3>* after) {
  const Complex& coarse = *fine.coarse;
  const Array<Vec3> unmoved = *after;
  for (int round = 0;; ++round) {
    const LocalRows rows = moveRows(stars);
    *after = unmoved;
    for (const Index v : rows.fine()) {
      rows.row(v, 1, [&](Index e, double weight) {
        (*after)[v] -= weight * (before[coarse.edges[e][1]] - before[coarse.edges[e][0]]);
      });
    }
    if (round == kRounds) return stars;
    std::vector<std::uint8_t> spoilt(stars.size(), 0);
    parallelFor<std::size_t>(
        stars.size(),
        [&](std::size_t k) {
          if (!stars[k].atWall && level > kOverlapping) return;
          spoilt[k] = spoils(stars[k], fine, unmoved, *after);
        },
        16);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < stars.size(); ++k) {
      if (!spoilt[k]) std::swap(stars[kept++], stars[k]);
    }
    if (kept == stars.size()) return stars;
    stars.resize(kept);
  }
}

}  // namespace octet
