// SPDX-License-Identifier: Apache-2.0
#include "real_part.h"

namespace octet {

// The numbering of scheme.md section 3, once for each mesh.
RealPart RealPart::child(const RealPart& coarse, const Complex& own, const Complex& larger) {
  RealPart result;
  const Index v = larger.vertexCount(), e = larger.edgeCount(), f = larger.facetCount(),
              t = larger.tetCount();
  const Index fineTets = 4 * t + 8 * larger.octCount();
  const auto& cells = coarse.places[3];
  const auto tet = [&](Index k) { return cells[static_cast<std::size_t>(k)]; };
  const auto oct = [&](Index k) { return cells[static_cast<std::size_t>(own.tetCount() + k)] - t; };
  const Index tets = own.tetCount(), octs = own.octCount();

  auto& vertices = result.places[0];
  vertices = coarse.places[0];
  for (const Index k : coarse.places[1]) vertices.push_back(v + k);
  for (Index k = 0; k < octs; ++k) vertices.push_back(v + e + oct(k));

  auto& edges = result.places[1];
  for (const Index k : coarse.places[1]) edges.insert(edges.end(), {2 * k, 2 * k + 1});
  for (const Index k : coarse.places[2]) {
    for (Index i = 0; i < 3; ++i) edges.push_back(2 * e + 3 * k + i);
  }
  for (Index k = 0; k < octs; ++k) {
    for (Index i = 0; i < 12; ++i) edges.push_back(2 * e + 3 * f + 12 * oct(k) + i);
  }

  auto& facets = result.places[2];
  for (const Index k : coarse.places[2]) {
    for (Index i = 0; i < 4; ++i) facets.push_back(4 * k + i);
  }
  for (Index k = 0; k < tets; ++k) {
    for (Index i = 0; i < 4; ++i) facets.push_back(4 * f + 4 * tet(k) + i);
  }
  for (Index k = 0; k < octs; ++k) {
    for (Index i = 0; i < 24; ++i) facets.push_back(4 * f + 4 * t + 24 * oct(k) + i);
  }

  auto& fine = result.places[3];
  for (Index k = 0; k < tets; ++k) {
    for (Index i = 0; i < 4; ++i) fine.push_back(4 * tet(k) + i);
  }
  for (Index k = 0; k < octs; ++k) {
    for (Index i = 0; i < 8; ++i) fine.push_back(4 * t + 8 * oct(k) + i);
  }
  for (Index k = 0; k < tets; ++k) fine.push_back(fineTets + tet(k));
  for (Index k = 0; k < octs; ++k) {
    for (Index i = 0; i < 6; ++i) fine.push_back(fineTets + t + 6 * oct(k) + i);
  }
  return result;
}

}  // namespace octet
