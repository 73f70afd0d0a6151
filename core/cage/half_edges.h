// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sharp_edges.h"
#include "triangle_surface.h"

namespace octet {

/// @brief A closed surface of triangles that can be changed: half-edge 3 t + k runs from vertex k
/// of triangle t to the next one, and its twin back, in the triangle across.
///
/// Each edge carries the sharp chain it belongs to (sharp_edges.h), or kNone. Operations keep the
/// surface a manifold, given that their conditions hold.
class HalfEdges {
 public:
  /// Triangles are turned to agree with their neighbours.
  /// @throws InputError for edges that do not have two triangles, vertices with more than one ring
  /// of triangles, and one-sided surfaces
  HalfEdges(const TriangleSurface& surface, const SharpEdges& sharp);

  Index next(Index h) const { return h % 3 == 2 ? h - 2 : h + 1; }
  Index prev(Index h) const { return h % 3 == 0 ? h + 2 : h - 1; }
  Index twin(Index h) const { return twin_[h]; }
  Index from(Index h) const { return from_[h]; }
  Index to(Index h) const { return from_[next(h)]; }
  /// The vertex across from the edge in this half-edge's triangle.
  Index apex(Index h) const { return from_[prev(h)]; }
  Index chain(Index h) const { return chain_[h]; }
  /// Half-edges ever made; those of triangles that are gone are not alive.
  Index count() const { return static_cast<Index>(from_.size()); }
  bool alive(Index h) const { return from_[h] != kNone; }
  Index vertexCount() const { return static_cast<Index>(out_.size()); }
  bool hasVertex(Index v) const { return out_[v] != kNone; }

  /// Calls visit(h) for the half-edges that leave a vertex, clockwise seen from outside.
  template <typename Visit>
  void visitRing(Index v, const Visit& visit) const {
    const Index first = out_[v];
    Index h = first;
    do {
      visit(h);
      h = twin_[prev(h)];
    } while (h != first);
  }
  Index valence(Index v) const;
  bool neighbours(Index a, Index b) const;

  /// Puts a new vertex on an edge and returns it.
  Index split(Index h);
  /// May the edge be turned to join the vertices across from it? It is not sharp, and no other edge
  /// joins them.
  bool canFlip(Index h) const;
  void flip(Index h);
  /// May from(h) be merged into to(h), as far as connections go (the link condition)?
  bool canCollapse(Index h) const;
  void collapse(Index h);

  /// Vertices still used, renumbered in order. @param positions  one per vertex
  /// @param edges  the sharp edges, by new numbers
  TriangleSurface surface(const std::vector<Vec3>& positions,
                          std::vector<std::array<Index, 2>>* edges) const;

 private:
  void orient(TriangleSurface* surface) const;
  void checkRings() const;
  void set(Index t, Index a, Index b, Index c);
  void join(Index h, Index g, Index chain);

  std::vector<Index> from_, twin_, chain_;  // by half-edge
  std::vector<Index> out_;                  // a half-edge that leaves each vertex
};

}  // namespace octet
