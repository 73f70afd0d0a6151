// SPDX-License-Identifier: Apache-2.0
#include "cell_kernels.h"

#include "smoothing_rules.h"

namespace octet {
namespace {

template <std::size_t N>
void addTo(std::array<double, N>* sum, const std::array<double, N>& row, double w) {
  for (std::size_t k = 0; k < N; ++k) (*sum)[k] += w * row[k];
}

template <typename Shape>
class KernelBuilder {
 public:
  KernelBuilder(const LinearRules& linear, CellKernel<Shape>* kernel)
      : local_(linear), kernel_(*kernel) {}

  void run() {
    const auto& split = SplitTables<Shape>::get();
    for (const auto& child : split.tets) addTet(child);
    for (const auto& child : split.octs) addOct(child);
    for (int f = 0; f < SplitTables<Shape>::kInside; ++f) {
      for (int k = 0; k < Shape::kFacets; ++k) kernel_.insideFacet[f][k] = local_.inside(f, k);
    }
    listFacets();
  }

 private:
  using EdgeRow = typename LocalLinear<Shape>::EdgeRow;
  using FacetRow = typename LocalLinear<Shape>::FacetRow;

  void addVertex(int label, const EdgeRow& row) {
    for (int k = 0; k < Shape::kEdges; ++k) kernel_.vertexHomotopy[k][label] += row[k];
  }
  void addEdge(int a, int b, const FacetRow& row) {
    const auto [edge, sign] = local_.find(a, b);
    for (int k = 0; k < Shape::kFacets; ++k) kernel_.edgeHomotopy[k][edge] += sign * row[k];
  }

  void addTet(const std::uint8_t* child) {
    for (int i = 0; i < 4; ++i) {
      EdgeRow row{};
      for (int j = 0; j < 4; ++j) {
        if (j != i) addTo(&row, local_.edge(child[i], child[j]), -kTetVertexWeight);
      }
      addVertex(child[i], row);
      for (int j = i + 1; j < 4; ++j) {
        FacetRow sum{};
        for (int w = 0; w < 4; ++w) {
          if (w != i && w != j) {
            addTo(&sum, local_.facet(child[i], child[j], child[w]), kTetEdgeWeight);
          }
        }
        addEdge(child[i], child[j], sum);
      }
    }
  }

  void addOct(const std::uint8_t* child) {
    const auto& opposite = Octahedron::opposite;
    for (int i = 0; i < 6; ++i) {
      EdgeRow row{};
      for (int j = 0; j < 6; ++j) {
        if (j == i || j == opposite[i]) continue;
        addTo(&row, local_.edge(child[i], child[j]), -kOctVertexWeight);
        addTo(&row, local_.edge(child[j], child[opposite[i]]), -kOctRingWeight);
      }
      addVertex(child[i], row);
    }
    for (const auto& [u, v] : Octahedron::edges) {
      const int U = opposite[u], W = opposite[v];
      FacetRow sum{};
      for (int p = 0; p < 6; ++p) {
        if (p == u || p == v || p == U || p == W) continue;
        addTo(&sum, local_.facet(child[u], child[v], child[p]), kOctEdgeWeights[0]);
        addTo(&sum, local_.facet(child[u], child[W], child[p]), kOctEdgeWeights[1]);
        addTo(&sum, local_.facet(child[U], child[v], child[p]), kOctEdgeWeights[1]);
        addTo(&sum, local_.facet(child[U], child[W], child[p]), kOctEdgeWeights[2]);
      }
      addEdge(child[u], child[v], sum);
    }
  }

  void listFacets() {
    const auto& split = SplitTables<Shape>::get();
    const auto collectInside = [](const ChildFacet* facets, int n, std::uint8_t* out) {
      int m = 0;
      for (int k = 0; k < n; ++k) {
        if (facets[k].inside) out[m++] = facets[k].facet;
      }
    };
    for (int i = 0; i < Shape::kVertices; ++i) {
      if constexpr (kTet) {
        collectInside(split.tetFacets[i], 4, kernel_.cornerInside[i]);
      } else {
        collectInside(split.octFacets[i], 8, kernel_.cornerInside[i]);
      }
      int m = 0;
      for (std::uint8_t f = 0; f < Shape::kFacets; ++f) {
        for (const int v : Shape::facets[f]) {
          if (v == i) kernel_.cornerFacets[i][m++] = f;
        }
      }
    }
    if constexpr (kTet) {
      collectInside(split.octFacets[0], 8, kernel_.innerInside[0]);
    } else {
      for (int f = 0; f < 8; ++f) collectInside(split.tetFacets[f], 4, kernel_.innerInside[f]);
    }
    int atSpoke[12] = {};
    for (std::uint8_t f = 0; f < SplitTables<Shape>::kInside; ++f) {
      for (int k = 0; k < (kTet ? 3 : 1); ++k) {
        const CutEdge& cut = split.insideCuts[f][k];
        kernel_.insideAtCut[cut.facet][cut.corner] = f;
      }
      if constexpr (!kTet) {
        for (const int spoke : split.insideSpokes[f]) {
          kernel_.insideAtSpoke[spoke][atSpoke[spoke]++] = f;
        }
      }
    }
  }

  static constexpr bool kTet = Shape::kVertices == 4;
  const LocalLinear<Shape> local_;
  CellKernel<Shape>& kernel_;
};

}  // namespace

template <typename Shape>
CellKernel<Shape>::CellKernel(const LinearRules& linear) {
  KernelBuilder<Shape>(linear, this).run();
}

template struct CellKernel<Tetrahedron>;
template struct CellKernel<Octahedron>;

}  // namespace octet
