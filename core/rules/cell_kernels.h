// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "local_linear.h"

/// @file
/// What one coarse cell contributes to the smoothing of its fine edges and vertices. Linear
/// subdivision of a cell depends on that cell alone, and so does a cell's part in the mean over a
/// star; so the rows D1 and D2 of irregular simplices (SCHEME.md section 6), applied after the
/// linear rule, are sums over coarse cells of small fixed matrices times the cell's own
/// coefficients.

namespace octet {

/// @brief The matrices of one shape. Columns are fine simplices, so that applying them is a sum of
/// scaled contiguous rows.
template <typename Shape>
struct CellKernel {
  explicit CellKernel(const LinearRules& linear);

  /// D1 of each fine vertex, times the number of its cells, from the cell's edges (lower to
  /// higher).
  double vertexHomotopy[Shape::kEdges][FineVertices<Shape>::kCount]{};
  /// D2 of each fine edge, times the number of its cells, from the cell's outward facets.
  double edgeHomotopy[Shape::kFacets][FineEdges<Shape>::kCount]{};
  /// Linear rule for the facets inside the cell, from its outward facets.
  double insideFacet[SplitTables<Shape>::kInside][Shape::kFacets]{};
  /// Inside facets of the child at a corner; and those of the children that are not at a corner.
  std::uint8_t cornerInside[Shape::kVertices][4]{};
  std::uint8_t innerInside[Shape::kVertices == 6 ? 8 : 1][4]{};
  /// Facets of the cell at a corner.
  std::uint8_t cornerFacets[Shape::kVertices][4]{};
  /// The inside facet at the edge that cuts off slot s of facet f, and the four at a spoke.
  std::uint8_t insideAtCut[Shape::kFacets][3]{};
  std::uint8_t insideAtSpoke[12][4]{};

  static constexpr int kFacetsAtCorner = Shape::kVertices == 6 ? 4 : 3;
  static constexpr int kInsideAtCorner = Shape::kVertices == 6 ? 4 : 1;
};

/// Both shapes' matrices for a value of zeta.
struct CellKernels {
  explicit CellKernels(double zeta) : linear(zeta), tet(linear), oct(linear) {}

  template <typename Shape>
  const CellKernel<Shape>& of() const {
    if constexpr (Shape::kVertices == 4) {
      return tet;
    } else {
      return oct;
    }
  }

  LinearRules linear;
  CellKernel<Tetrahedron> tet;
  CellKernel<Octahedron> oct;
};

}  // namespace octet
