// SPDX-License-Identifier: Apache-2.0
#include "star_sums.h"

#include <algorithm>

namespace octet {

StarSums::StarSums(const Complex& coarse) : c_(coarse) {
  const auto accumulate = [](Array<std::uint32_t>* begin) {
    for (std::size_t k = 1; k < begin->size(); ++k) (*begin)[k] += (*begin)[k - 1];
    return begin->back();
  };
  edgeBegin_.assign(c_.edgeCount() + 1, 0);
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    c_.visitEdgeStar(e, [&](const CellAtEdge&) { ++edgeBegin_[e + 1]; });
  });
  edgeEntries_.resize(accumulate(&edgeBegin_));
  parallelFor<Index>(c_.edgeCount(), [&](Index e) {
    EdgeEntry* next = edgeEntries_.data() + edgeBegin_[e];
    c_.visitEdgeStar(e, [&](const CellAtEdge& at) {
      const int k = c_.isTet(at.cell) ? kCellTables<Tetrahedron>.edgeBetween[at.start][at.end]
                                      : kCellTables<Octahedron>.edgeBetween[at.start][at.end];
      *next++ = EdgeEntry(at.cell, k, at.start < at.end);
    });
  });
  vertexBegin_.assign(c_.vertexCount() + 1, 0);
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    c_.visitVertexStar(v, [&](const CellAtVertex&) { ++vertexBegin_[v + 1]; });
  });
  vertexEntries_.resize(accumulate(&vertexBegin_));
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    VertexEntry* next = vertexEntries_.data() + vertexBegin_[v];
    c_.visitVertexStar(v,
                       [&](const CellAtVertex& at) { *next++ = VertexEntry(at.cell, at.place); });
  });
}

int StarSums::cellsAtVertex(const ChildOf& vertex) const {
  if (vertex.origin == Origin::Octahedron) return 14;
  if (vertex.origin == Origin::Vertex) {
    return std::max(static_cast<int>(vertexBegin_[vertex.parent + 1] - vertexBegin_[vertex.parent]),
                    1);
  }
  // Two corner children of each cell, the octahedron of a tetrahedron, two tetrahedra of an
  // octahedron.
  int n = 0;
  visitVertex(vertex, [&](Index cell, int) { n += c_.isTet(cell) ? 3 : 4; });
  return n;
}

}  // namespace octet
