// SPDX-License-Identifier: Apache-2.0
#include "coboundary_matrix.h"

#include <vector>

namespace octet {

template <int K>
Eigen::SparseMatrix<double> coboundaryMatrix(const Complex& complex) {
  std::vector<Eigen::Triplet<double, Index>> entries;
  if constexpr (K == 0) {
    for (Index e = 0; e < complex.edgeCount(); ++e) {
      entries.emplace_back(e, complex.edges[e][0], -1);
      entries.emplace_back(e, complex.edges[e][1], 1);
    }
  } else if constexpr (K == 1) {
    for (Index f = 0; f < complex.facetCount(); ++f) {
      for (const EdgeRef& e : complex.facetEdges[f]) entries.emplace_back(f, e.index(), e.sign());
    }
  } else {
    for (Index cell = 0; cell < complex.cellCount(); ++cell) {
      for (int k = 0; k < complex.cellFacetCount(cell); ++k) {
        const FacetRef f = complex.cellFacet(cell, k);
        entries.emplace_back(cell, f.index(), complex.cellSigns[cell] * f.sign());
      }
    }
  }
  Eigen::SparseMatrix<double> result(complex.count(K + 1), complex.count(K));
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

template Eigen::SparseMatrix<double> coboundaryMatrix<0>(const Complex&);
template Eigen::SparseMatrix<double> coboundaryMatrix<1>(const Complex&);
template Eigen::SparseMatrix<double> coboundaryMatrix<2>(const Complex&);

}  // namespace octet
