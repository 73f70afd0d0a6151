// SPDX-License-Identifier: Apache-2.0
#include "star_patterns.h"

#include <algorithm>
#include <array>

namespace octet {
namespace {

constexpr int kTets = StarPatterns::kTets, kCells = StarPatterns::kCells;

/// Tetrahedra and octahedra at a vertex meet in facets where the octant has the axis' sign.
bool adjacent(int tet, int oct) { return ((tet >> (oct / 2)) & 1) == (oct & 1); }

std::array<std::uint16_t, kCells> neighbourMasks() {
  std::array<std::uint16_t, kCells> masks{};
  for (int t = 0; t < kTets; ++t) {
    for (int o = 0; o < StarPatterns::kOcts; ++o) {
      if (!adjacent(t, o)) continue;
      masks[t] |= static_cast<std::uint16_t>(1u << (kTets + o));
      masks[kTets + o] |= static_cast<std::uint16_t>(1u << t);
    }
  }
  return masks;
}

bool connected(std::uint16_t cells, const std::array<std::uint16_t, kCells>& neighbours) {
  std::uint16_t reached = cells & static_cast<std::uint16_t>(-cells), before = 0;
  while (reached != before) {
    before = reached;
    for (int c = 0; c < kCells; ++c) {
      if (before >> c & 1) reached |= neighbours[c] & cells;
    }
  }
  return reached == cells;
}

/// Around each of the 12 lattice edges at the vertex: two octahedra across from each other, and
/// the two tetrahedra between them.
struct AroundEdge {
  std::uint16_t octs, tets;
};

std::vector<AroundEdge> edgeStars() {
  std::vector<AroundEdge> stars;
  for (int i = 0; i < 6; ++i) {
    for (int j = i + 1; j < 6; ++j) {
      if (i / 2 == j / 2) continue;
      AroundEdge star = {static_cast<std::uint16_t>(1u << (kTets + i) | 1u << (kTets + j)), 0};
      for (int t = 0; t < kTets; ++t) {
        if (adjacent(t, i) && adjacent(t, j)) star.tets |= static_cast<std::uint16_t>(1u << t);
      }
      stars.push_back(star);
    }
  }
  return stars;
}

}  // namespace

StarPatterns::StarPatterns() {
  for (int t = 0; t < kTets; ++t) {
    const int s[3] = {t & 1 ? -1 : 1, t & 2 ? -1 : 1, t & 4 ? -1 : 1};
    vertices_[t] = {{s[0], s[1], 0}, {s[0], 0, s[2]}, {0, s[1], s[2]}};
  }
  for (int o = 0; o < kOcts; ++o) {
    Int3 axis{};
    const int k = o / 2, s = o & 1 ? -1 : 1;
    axis[k] = s;
    for (int j = 0; j < 6; ++j) {
      Int3 p = axis;
      p[j / 2] += j & 1 ? -1 : 1;
      if (p != Int3{}) vertices_[kTets + o].push_back(p);
    }
  }
  for (const auto& list : vertices_) {
    for (const Int3& p : list) {
      if (std::find(around_.begin(), around_.end(), p) == around_.end()) around_.push_back(p);
    }
  }
  findJoints();

  const auto neighbours = neighbourMasks();
  const auto edges = edgeStars();
  manifold_.resize(kAll + 1u);
  for (unsigned cells = 0; cells <= kAll; ++cells) {
    const auto in = static_cast<std::uint16_t>(cells);
    const auto out = static_cast<std::uint16_t>(kAll & ~cells);
    // A part of the sphere is a disc when it and the rest are connected and nowhere touch
    // themselves in a point.
    manifold_[cells] = in == 0 || out == 0 ||
                       (connected(in, neighbours) && connected(out, neighbours) &&
                        std::none_of(edges.begin(), edges.end(), [&](const AroundEdge& e) {
                          const std::uint16_t here = in & (e.octs | e.tets);
                          return here == e.octs || here == e.tets;
                        }));
  }
}

void StarPatterns::findJoints() {
  const auto add = [&](const std::vector<int>& vertices) {
    Joint joint{vertices, 0};
    for (int c = 0; c < kCells; ++c) {
      const auto& list = vertices_[c];
      const bool all = std::all_of(vertices.begin(), vertices.end(), [&](int v) {
        return std::find(list.begin(), list.end(), around_[v]) != list.end();
      });
      if (all) joint.cells |= static_cast<std::uint16_t>(1u << c);
    }
    joints_.push_back(joint);
  };
  constexpr int kNeighbours = 12;
  for (int v = 0; v < kNeighbours; ++v) add({v});
  for (int v = 0; v < kNeighbours; ++v) {
    for (int w = v + 1; w < kNeighbours; ++w) {
      int square = 0;
      for (int k = 0; k < 3; ++k)
        square += (around_[v][k] - around_[w][k]) * (around_[v][k] - around_[w][k]);
      if (square == 2) add({v, w});  // neighbours of each other
    }
  }
}

}  // namespace octet
