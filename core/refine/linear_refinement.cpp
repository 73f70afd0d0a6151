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
  const ChildNumbering children = coarse.children();
  parallelFor<Index>(coarse.vertexCount(), [&](Index k) { out[k] = in[k]; });
  parallelFor<Index>(coarse.edgeCount(), [&](Index k) {
    out[children.midpoint(k)] = (in[coarse.edges[k][0]] + in[coarse.edges[k][1]]) / 2;
  });
  parallelFor<Index>(coarse.octCount(), [&](Index k) {
    double sum = 0;
    for (const Index corner : coarse.octs[k]) sum += in[corner];
    out[children.centre(k)] = sum / 6;
  });
}

void LinearRefinement::apply1(const Complex& coarse, const double* in, double* out) const {
  const ChildNumbering children = coarse.children();
  parallelFor<Index>(coarse.edgeCount(), [&](Index e) {
    out[children.half(e, 0)] = out[children.half(e, 1)] = in[e] / 2;
  });
  parallelFor<Index>(coarse.facetCount(), [&](Index f) {
    const auto& edges = coarse.facetEdges[f];
    const double ab = edges[0].sign() * in[edges[0].index()] / 4;
    const double bc = edges[1].sign() * in[edges[1].index()] / 4;
    const double ac = -edges[2].sign() * in[edges[2].index()] / 4;
    out[children.cut(f, 0)] = bc + ac - ab;  // (ab,ac), around a
    out[children.cut(f, 1)] = ac + bc + ab;  // (ab,bc), around b
    out[children.cut(f, 2)] = ab + ac - bc;  // (ac,bc), around c
  });
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    std::array<double, 12> values;
    for (int k = 0; k < 12; ++k) {
      const EdgeRef e = coarse.octEdge(o, k);
      values[k] = e.sign() * in[e.index()];
    }
    for (int k = 0; k < 12; ++k) out[children.spoke(o, k)] = dot(rules_.octSpoke[k], values);
  });
}

void LinearRefinement::apply2(const Complex& coarse, const double* in, double* out) const {
  const ChildNumbering children = coarse.children();
  parallelFor<Index>(coarse.facetCount(), [&](Index f) {
    for (int k = 0; k < 4; ++k) out[children.onFacet(f, k)] = in[f] / 4;
  });
  parallelFor<Index>(coarse.tetCount(), [&](Index t) {
    const auto values = outward(coarse.tetFacets[t], in);
    for (int k = 0; k < 4; ++k) out[children.inTet(t, k)] = dot(rules_.tetFacet[k], values);
  });
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    const auto values = outward(coarse.octFacets[o], in);
    for (int k = 0; k < 24; ++k) out[children.inOct(o, k)] = dot(rules_.octFacet[k], values);
  });
}

void LinearRefinement::apply3(const Complex& coarse, const double* in, double* out) const {
  const ChildNumbering children = coarse.children();
  const Index tets = coarse.tetCount();
  parallelFor<Index>(tets, [&](Index t) {
    for (int k = 0; k < 4; ++k) out[children.cornerTet(t, k)] = LinearRules::kTetToTet * in[t];
    out[children.innerOct(t)] = LinearRules::kTetToOct * in[t];
  });
  parallelFor<Index>(coarse.octCount(), [&](Index o) {
    const double mass = in[tets + o];
    for (int k = 0; k < 8; ++k) out[children.innerTet(o, k)] = LinearRules::kOctToTet * mass;
    for (int k = 0; k < 6; ++k) out[children.cornerOct(o, k)] = LinearRules::kOctToOct * mass;
  });
}

}  // namespace octet
