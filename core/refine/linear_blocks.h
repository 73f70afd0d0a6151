// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../rules/linear_rules.h"
#include "../topology/complex.h"

/// @file
/// The linear rules L1 and L2 (SCHEME.md section 4) on a mesh, once: a coarse simplex and the fine
/// simplices that lie in it are a block, which reads a few coarse coefficients, `input(k)`, with a
/// row of weights for each child. LinearRefinement refines a level block by block; `linearRow` is
/// the row of a single fine simplex.

namespace octet {

/// The block of K-forms of one kind of coarse simplex.
template <int K, Origin kOrigin>
struct LinearBlock;

template <>
struct LinearBlock<1, Origin::Edge> {
  static constexpr int kChildren = 2;
  static EdgeRef input(const Complex&, Index edge, int) { return EdgeRef(edge, false); }
  static Index child(const ChildNumbering& n, Index edge, int end) { return n.half(edge, end); }
  static const auto& row(const LinearRules&, int) { return LinearRules::kHalf; }
};

template <>
struct LinearBlock<1, Origin::Facet> {
  static constexpr int kChildren = 3;
  static EdgeRef input(const Complex& c, Index facet, int k) {
    return c.facetEdge(facet, LinearRules::kCutInputs[k][0], LinearRules::kCutInputs[k][1]);
  }
  static Index child(const ChildNumbering& n, Index facet, int k) { return n.cut(facet, k); }
  static const auto& row(const LinearRules&, int corner) { return LinearRules::kCut[corner]; }
};

template <>
struct LinearBlock<1, Origin::Octahedron> {
  static constexpr int kChildren = 12;
  static EdgeRef input(const Complex& c, Index oct, int k) { return c.octEdge(oct, k); }
  static Index child(const ChildNumbering& n, Index oct, int k) { return n.spoke(oct, k); }
  static const auto& row(const LinearRules& rules, int k) { return rules.octSpoke[k]; }
};

template <>
struct LinearBlock<2, Origin::Facet> {
  static constexpr int kChildren = 4;
  static FacetRef input(const Complex&, Index facet, int) { return FacetRef(facet, 0); }
  static Index child(const ChildNumbering& n, Index facet, int k) { return n.onFacet(facet, k); }
  static const auto& row(const LinearRules&, int) { return LinearRules::kQuarter; }
};

template <>
struct LinearBlock<2, Origin::Tetrahedron> {
  static constexpr int kChildren = 4;
  static FacetRef input(const Complex& c, Index tet, int k) { return c.tetFacets[tet][k]; }
  static Index child(const ChildNumbering& n, Index tet, int k) { return n.inTet(tet, k); }
  static const auto& row(const LinearRules& rules, int k) { return rules.tetFacet[k]; }
};

template <>
struct LinearBlock<2, Origin::Octahedron> {
  static constexpr int kChildren = 24;
  static FacetRef input(const Complex& c, Index oct, int k) { return c.octFacets[oct][k]; }
  static Index child(const ChildNumbering& n, Index oct, int k) { return n.inOct(oct, k); }
  static const auto& row(const LinearRules& rules, int k) { return rules.octFacet[k]; }
};

/// Calls `add(coarse simplex, weight)` for the row of a fine edge (K = 1) or facet (K = 2).
template <int K, typename Add>
void linearRow(const Complex& coarse, const LinearRules& rules, Index fine, double weight,
               const Add& add) {
  static_assert(K == 1 || K == 2);
  const ChildNumbering children = coarse.children();
  const ChildOf child = K == 1 ? children.edge(fine) : children.facet(fine);
  const auto addRow = [&](auto block) {
    const auto& row = block.row(rules, child.place);
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (row[k] == 0) continue;
      const auto input = block.input(coarse, child.parent, static_cast<int>(k));
      add(input.index(), weight * row[k] * input.sign());
    }
  };
  if (child.origin == Origin::Facet) {
    addRow(LinearBlock<K, Origin::Facet>{});
  } else if (child.origin == Origin::Octahedron) {
    addRow(LinearBlock<K, Origin::Octahedron>{});
  } else {
    addRow(LinearBlock < K, K == 1 ? Origin::Edge : Origin::Tetrahedron > {});
  }
}

}  // namespace octet
