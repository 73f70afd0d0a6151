// SPDX-License-Identifier: Apache-2.0
#include "linear_refinement.h"

#include "../base/parallel.h"
#include "linear_blocks.h"

namespace octet {
namespace {

/// Refines all `count` blocks of one kind.
template <typename Block>
void applyBlocks(const Complex& coarse, const LinearRules& rules, Index count, const double* in,
                 double* out) {
  const ChildNumbering children = coarse.children();
  parallelFor<Index>(count, [&](Index parent) {
    auto values = Block::row(rules, 0);  // as many
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto input = Block::input(coarse, parent, static_cast<int>(k));
      values[k] = input.sign() * in[input.index()];
    }
    for (int k = 0; k < Block::kChildren; ++k) {
      const auto& row = Block::row(rules, k);
      double sum = 0;
      for (std::size_t j = 0; j < row.size(); ++j) sum += row[j] * values[j];
      out[Block::child(children, parent, k)] = sum;
    }
  });
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
  applyBlocks<LinearBlock<1, Origin::Edge>>(coarse, rules_, coarse.edgeCount(), in, out);
  applyBlocks<LinearBlock<1, Origin::Facet>>(coarse, rules_, coarse.facetCount(), in, out);
  applyBlocks<LinearBlock<1, Origin::Octahedron>>(coarse, rules_, coarse.octCount(), in, out);
}

void LinearRefinement::apply2(const Complex& coarse, const double* in, double* out) const {
  applyBlocks<LinearBlock<2, Origin::Facet>>(coarse, rules_, coarse.facetCount(), in, out);
  applyBlocks<LinearBlock<2, Origin::Tetrahedron>>(coarse, rules_, coarse.tetCount(), in, out);
  applyBlocks<LinearBlock<2, Origin::Octahedron>>(coarse, rules_, coarse.octCount(), in, out);
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
