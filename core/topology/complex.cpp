// SPDX-License-Identifier: Apache-2.0
#include "complex.h"

namespace octet {

Index Complex::count(int k) const {
  switch (k) {
    case 0:
      return vertexCount();
    case 1:
      return edgeCount();
    case 2:
      return facetCount();
    default:
      return cellCount();
  }
}

EdgeRef Complex::cellEdge(Index cell, int from, int to) const {
  const EdgeRef edge =
      isTet(cell) ? tetEdge(cell, kCellTables<Tetrahedron>.edgeBetween[from][to])
                  : octEdge(cell - tetCount(), kCellTables<Octahedron>.edgeBetween[from][to]);
  return edge.flippedIf(from > to);
}

std::array<Index, 3> Complex::facetVertices(Index facet) const {
  std::array<Index, 3> vertices;
  for (int k = 0; k < 3; ++k) {
    const EdgeRef edge = facetEdges[facet][k];
    vertices[k] = edges[edge.index()][edge.reversed() ? 1 : 0];
  }
  return vertices;
}

}  // namespace octet
