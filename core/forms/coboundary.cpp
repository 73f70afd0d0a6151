// SPDX-License-Identifier: Apache-2.0
#include "coboundary.h"

#include <algorithm>
#include <cmath>

#include "../base/parallel.h"

namespace octet {

void coboundary0(const Complex& complex, const double* vertices, double* edges) {
  parallelFor<Index>(complex.edgeCount(), [&](Index e) {
    edges[e] = vertices[complex.edges[e][1]] - vertices[complex.edges[e][0]];
  });
}

void coboundary1(const Complex& complex, const double* edges, double* facets) {
  parallelFor<Index>(complex.facetCount(), [&](Index f) {
    double sum = 0;
    for (const EdgeRef& e : complex.facetEdges[f]) sum += e.sign() * edges[e.index()];
    facets[f] = sum;
  });
}

void coboundary2(const Complex& complex, const double* facets, double* cells) {
  parallelFor<Index>(complex.cellCount(), [&](Index cell) {
    double sum = 0;
    for (int k = 0; k < complex.cellFacetCount(cell); ++k) {
      const FacetRef f = complex.cellFacet(cell, k);
      sum += f.sign() * facets[f.index()];
    }
    cells[cell] = complex.cellSigns[cell] * sum;
  });
}

Cochain<1> d(const Complex& complex, const Cochain<0>& f) {
  f.checkOn(complex);
  Cochain<1> result(complex);
  coboundary0(complex, f.data(), result.data());
  return result;
}

Cochain<2> d(const Complex& complex, const Cochain<1>& w) {
  w.checkOn(complex);
  Cochain<2> result(complex);
  coboundary1(complex, w.data(), result.data());
  return result;
}

Cochain<3> d(const Complex& complex, const Cochain<2>& w) {
  w.checkOn(complex);
  Cochain<3> result(complex);
  coboundary2(complex, w.data(), result.data());
  return result;
}

double maxNorm(const Array<double>& values) {
  double result = 0;
  for (const double x : values) result = std::max(result, std::abs(x));
  return result;
}

}  // namespace octet
