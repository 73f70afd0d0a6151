// SPDX-License-Identifier: Apache-2.0
#include "linear_refinement.h"

#include "../base/parallel.h"

namespace octet {
namespace {

/// Coefficients of a cell's facets, seen outward of its tables.
template <std::size_t N>
std::array<double, N> outward(const std::array<FacetRef, N>& facets, const double* values) {
  std::array<double, N> result;
  for (std::size_t k = 0; k < N; ++k) result[k] = facets[k].sign() * values[facets[k].index()];
  return result;
}

template <typename Row>
double dot(const Row& row, const Row& values) {
  double sum = 0;
  for (std::size_t k = 0; k < row.size(); ++k) sum += row[k] * values[k];
  return sum;
}

}  // namespace

void LinearRefinement::apply0(const Complex& coarse, const double* in, double* out) const {
  const Index v = coarse.vertexCount(), e = coarse.edgeCount();
  parallelFor<Index>(v, [&](Index k) { out[k] = in[k]; });
  parallelFor<Index>(
      e, [&](Index k) { out[v + k] = (in[coarse.edges[k][0]] + in[coarse.edges[k][1]]) / 2; });
  parallelFor<Index>(coarse.octCount(), [&](Index k) {
    double sum = 0;
    for (const Index corner : coarse.octs[k]) sum += in[corner];
    out[v + e + k] = sum / 6;
  });
}

void LinearRefinement::apply1(const Complex& coarse, const double* in, double* out) const {
  parallelFor<Index>(coarse.edgeCount(), [&](Index e) { out[2 * e] = out[2 * e + 1] = in[e] / 2; });
  double* const cuts = out + 2 * static_cast<std::size_t>(coarse.edgeCount());
  parallelFor<Index>(coarse.facetCount(), [&](Index f) {
    const auto& edges = coarse.facetEdges[f];
    const double ab = edges[0].sign() * in[edges[0].index()] / 4;
    const double bc = edges[1].sign() * in[edges[1].index()] / 4;
    const double ac = -edges[2].sign() * in[edges[2].index()] / 4;
    cuts[3 * f] = bc + ac - ab;      // (ab,ac), around a
    cuts[3 * f + 1] = ac + bc + ab;  // (ab,bc), around b
    cuts[3 * f + 2] = ab + ac - bc;  // (ac,bc), around c
  });
  double* const spokes = cuts + 3 * static_cast<std::size_t>(coarse.facetCount());
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    std::array<double, 12> values;
    for (int k = 0; k < 12; ++k) {
      const EdgeRef e = coarse.octEdge(o, k);
      values[k] = e.sign() * in[e.index()];
    }
    for (int k = 0; k < 12; ++k) spokes[12 * o + k] = dot(rules_.octSpoke[k], values);
  });
}

void LinearRefinement::apply2(const Complex& coarse, const double* in, double* out) const {
  parallelFor<Index>(coarse.facetCount(), [&](Index f) {
    for (int k = 0; k < 4; ++k) out[4 * f + k] = in[f] / 4;
  });
  double* const inTets = out + 4 * static_cast<std::size_t>(coarse.facetCount());
  parallelFor<Index>(coarse.tetCount(), [&](Index t) {
    const auto values = outward(coarse.tetFacets[t], in);
    for (int k = 0; k < 4; ++k) inTets[4 * t + k] = dot(rules_.tetFacet[k], values);
  });
  double* const inOcts = inTets + 4 * static_cast<std::size_t>(coarse.tetCount());
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    const auto values = outward(coarse.octFacets[o], in);
    for (int k = 0; k < 24; ++k) inOcts[24 * o + k] = dot(rules_.octFacet[k], values);
  });
}

void LinearRefinement::apply3(const Complex& coarse, const Complex& fine, const double* in,
                              double* out) const {
  const Index tets = coarse.tetCount(), fineTets = fine.tetCount();
  parallelFor<Index>(tets, [&](Index t) {
    for (int k = 0; k < 4; ++k) out[4 * t + k] = LinearRules::kTetToTet * in[t];
    out[fineTets + t] = LinearRules::kTetToOct * in[t];
  });
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    const double mass = in[tets + o];
    for (int k = 0; k < 8; ++k) out[4 * tets + 8 * o + k] = LinearRules::kOctToTet * mass;
    for (int k = 0; k < 6; ++k) {
      out[fineTets + tets + 6 * o + k] = LinearRules::kOctToOct * mass;
    }
  });
}

}  // namespace octet
