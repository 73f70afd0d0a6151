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

/// A child of a star, by number.
struct Claim {
  Index child;
  std::uint32_t star, number;
  bool operator<(const Claim& other) const {
    return std::tie(child, star, number) < std::tie(other.child, other.star, other.number);
  }
};

/// The children of all stars, ascending.
std::vector<Claim> claimsOf(const std::vector<StarMoves>& stars) {
  std::vector<Claim> claims;
  for (std::size_t s = 0; s < stars.size(); ++s) {
    for (std::size_t k = 0; k < stars[s].children.size(); ++k) {
      claims.push_back(
          {stars[s].children[k], static_cast<std::uint32_t>(s), static_cast<std::uint32_t>(k)});
    }
  }
  std::sort(claims.begin(), claims.end());
  return claims;
}

/// Calls `visit(first, last, share)` for the claims on each child; each counts with that share.
template <typename Visit>
void visitChildren(const std::vector<Claim>& claims, const std::vector<StarMoves>& stars,
                   const Visit& visit) {
  for (std::size_t first = 0, last; first < claims.size(); first = last) {
    for (last = first; last < claims.size() && claims[last].child == claims[first].child;) ++last;
    const bool mean = stars[claims[first].star].atWall;
    visit(first, last, mean ? 1.0 / static_cast<double>(last - first) : 1.0);
  }
}

/// Does a star move a cell's vertices so that the cell is spoilt?
bool spoils(const StarMoves& star, const Complex& fine, const Array<Vec3>& unmoved,
            const Array<Vec3>& moved) {
  const double least = star.atWall ? kLeastAtWalls : kLeastInside;
  bool result = false;
  for (const Index child : star.children) {
    fine.visitVertexStar(child, [&](const CellAtVertex& at) {
      const double sign = fine.cellSigns[at.cell];
      const double without = sign * cellVolume6(fine, unmoved, at.cell);
      const double with = sign * cellVolume6(fine, moved, at.cell);
      if (without <= 0 || with < least * without) result = true;
    });
  }
  return result;
}

}  // namespace

LocalRows moveRows(const std::vector<StarMoves>& stars) {
  struct Row {
    std::size_t first, last;
    double share;
  };
  const std::vector<Claim> claims = claimsOf(stars);
  std::vector<Index> fine;
  std::vector<Row> rows;
  visitChildren(claims, stars, [&](std::size_t first, std::size_t last, double share) {
    fine.push_back(claims[first].child);
    rows.push_back({first, last, share});
  });
  return LocalRows(fine, [&](Index k, const auto& add) {
    for (std::size_t c = rows[k].first; c < rows[k].last; ++c) {
      const StarMoves& star = stars[claims[c].star];
      for (std::size_t t = star.begin[claims[c].number]; t < star.begin[claims[c].number + 1];
           ++t) {
        add(star.terms[t].coarseEdge, rows[k].share * star.terms[t].weight);
      }
    }
  });
}

std::vector<StarMoves> soundMoves(const Complex& fine, int level, const Array<Vec3>& before,
                                  std::vector<StarMoves> stars, Array<Vec3>* after) {
  const Complex& coarse = *fine.coarse;
  const Array<Vec3> unmoved = *after;
  for (int round = 0;; ++round) {
    // Where the stars' children go.
    std::vector<std::vector<Vec3>> moves(stars.size());
    parallelFor<std::size_t>(
        stars.size(),
        [&](std::size_t s) {
          const StarMoves& star = stars[s];
          for (std::size_t k = 0; k < star.children.size(); ++k) {
            Vec3 move = Vec3::Zero();
            for (std::size_t t = star.begin[k]; t < star.begin[k + 1]; ++t) {
              const auto& [a, b] = coarse.edges[star.terms[t].coarseEdge];
              move -= star.terms[t].weight * (before[b] - before[a]);
            }
            moves[s].push_back(move);
          }
        },
        16);
    const std::vector<Claim> claims = claimsOf(stars);
    visitChildren(claims, stars, [&](std::size_t first, std::size_t last, double share) {
      Vec3& position = (*after)[claims[first].child];
      position = unmoved[claims[first].child];
      for (std::size_t c = first; c < last; ++c) {
        position += share * moves[claims[c].star][claims[c].number];
      }
    });
    if (round == kRounds) return stars;
    std::vector<std::uint8_t> spoilt(stars.size(), 0);
    parallelFor<std::size_t>(
        stars.size(),
        [&](std::size_t k) {
          if (!stars[k].atWall && level > kOverlapping) return;
          spoilt[k] = spoils(stars[k], fine, unmoved, *after);
        },
        16);
    std::vector<StarMoves> kept;
    for (std::size_t k = 0; k < stars.size(); ++k) {
      if (!spoilt[k]) {
        kept.push_back(std::move(stars[k]));
        continue;
      }
      for (const Index child : stars[k].children) (*after)[child] = unmoved[child];
    }
    const bool all = kept.size() == stars.size();
    stars = std::move(kept);
    if (all) return stars;
  }
}

}  // namespace octet
