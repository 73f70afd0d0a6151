// SPDX-License-Identifier: Apache-2.0
#include "extension.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <atomic>
#include <set>

#include "../base/parallel.h"
#include "voids.h"

namespace octet {
namespace {

/// A chain misses its boundary when it does by more than this.
constexpr double kMissed = 1e-9;
/// Weights below this are rounding.
constexpr double kNoWeight = 1e-14;
/// A patch grows at most this often, a ring of cells at a time, until a chain exists in it.
constexpr int kMostRings = 4;

/// Boundary of a simplex: signed simplices of one dimension less, in stored orientation.
template <int K>
SparseChain boundaryOf(const Complex& c, Index simplex) {
  SparseChain result;
  if constexpr (K == 1) {
    result = {{c.edges[simplex][0], -1.0}, {c.edges[simplex][1], 1.0}};
  } else if constexpr (K == 2) {
    for (const EdgeRef& e : c.facetEdges[simplex]) result.emplace_back(e.index(), e.sign());
  } else {
    for (int k = 0; k < c.cellFacetCount(simplex); ++k) {
      const FacetRef f = c.cellFacet(simplex, k);
      result.emplace_back(f.index(), f.sign() * c.cellSigns[simplex]);
    }
  }
  return result;
}

/// The K-simplices of a set of cells.
template <int K>
std::vector<Index> simplicesOf(const Complex& c, const std::set<Index>& cells) {
  std::vector<Index> result;
  for (const Index cell : cells) {
    if (K == 3) result.push_back(cell);
    for (int k = 0; k < c.cellFacetCount(cell) && K < 3; ++k) {
      const Index f = c.cellFacet(cell, k).index();
      if (K == 2) result.push_back(f);
      if (K == 1) {
        for (const EdgeRef& e : c.facetEdges[f]) result.push_back(e.index());
      }
      if (K == 0) {
        for (const Index v : c.facetVertices(f)) result.push_back(v);
      }
    }
  }
  std::sort(result.begin(), result.end());
  result.erase(std::unique(result.begin(), result.end()), result.end());
  return result;
}

template <int K>
std::vector<Index> verticesOf(const Complex& c, Index simplex) {
  if constexpr (K == 0) return {simplex};
  if constexpr (K == 1) return {c.edges[simplex][0], c.edges[simplex][1]};
  if constexpr (K == 2) {
    const auto v = c.facetVertices(simplex);
    return {v.begin(), v.end()};
  }
  std::vector<Index> result;
  for (int i = 0; i < c.cellVertexCount(simplex); ++i) result.push_back(c.cellVertex(simplex, i));
  return result;
}

Index placeIn(const std::vector<Index>& sorted, Index x) {
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), x);
  return at != sorted.end() && *at == x ? static_cast<Index>(at - sorted.begin()) : kNone;
}

/// The x nearest to `guess` with A x = b. Rows may depend on one another: the square is shifted a
/// little, which a few steps make up for.
Eigen::VectorXd nearest(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd guess) {
  constexpr double kShift = 1e-7;
  constexpr int kSteps = 6;
  Eigen::MatrixXd square = a * a.transpose();
  square.diagonal().array() += kShift;
  const Eigen::LLT<Eigen::MatrixXd> factors(square);
  for (int k = 0; k < kSteps; ++k) guess += a.transpose() * factors.solve(b - a * guess);
  return guess;
}

}  // namespace

class Extension::Builder {
 public:
  Builder(const ControlMesh& mesh, const VirtualLayer& layer, const ControlMesh& expanded,
          Extension* out)
      : layer_(layer),
        x_(expanded.positions()),
        c_(*mesh.complex()),
        e_(*expanded.complex()),
        out_(*out) {
    embed(expanded);
    chains_[0].resize(static_cast<std::size_t>(e_.vertexCount()));
    for (Index v = 0; v < e_.vertexCount(); ++v) {
      const bool real = v < c_.vertexCount();
      chainOf<0>(v) = real ? SparseChain{{v, 1.0}}
                           : layer.vertices[static_cast<std::size_t>(v - c_.vertexCount())];
    }
    build<1>();
    build<2>();
    unwind();
    build<3>();
    for (int k = 0; k < 4; ++k) keep(k);
  }

 private:
  template <int K>
  SparseChain& chainOf(Index simplex) {
    return chains_[K][static_cast<std::size_t>(simplex)];
  }

  void embed(const ControlMesh& expanded) {
    for (Index v = 0; v < c_.vertexCount(); ++v) out_.embedding_[0].push_back(v);
    for (const auto& [a, b] : c_.edges) out_.embedding_[1].push_back(expanded.edge(a, b).index());
    for (Index f = 0; f < c_.facetCount(); ++f) {
      const auto [a, b, d] = c_.facetVertices(f);
      out_.embedding_[2].push_back(expanded.facet(a, b, d).index());
    }
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      out_.embedding_[3].push_back(c_.isTet(cell) ? cell : e_.tetCount() + (cell - c_.tetCount()));
    }
  }

  template <int K>
  void build() {
    chains_[K].resize(static_cast<std::size_t>(e_.count(K)));
    std::vector<std::uint8_t> real(chains_[K].size(), 0);
    for (std::size_t s = 0; s < out_.embedding_[K].size(); ++s) {
      const Index at = out_.embedding_[K][s];
      chainOf<K>(at) = {{static_cast<Index>(s), 1.0}};
      real[static_cast<std::size_t>(at)] = 1;
    }
    if (K < 3 && !layer_.sites.empty()) listBySites<K>();
    std::atomic<bool> exact{true};
    parallelFor<Index>(
        e_.count(K),
        [&](Index s) {
          if (real[static_cast<std::size_t>(s)]) return;
          if (!buildChain<K>(s)) exact = false;
        },
        4);
    out_.exact_ = out_.exact_ && exact;
  }

  /// What the boundary of a virtual simplex' chain has to be.
  template <int K>
  std::map<Index, double> wantedBoundary(Index simplex) {
    std::map<Index, double> result;
    for (const auto& [face, sign] : boundaryOf<K>(e_, simplex)) {
      for (const auto& [s, w] : chainOf<K - 1>(face)) result[s] += sign * w;
    }
    return result;
  }

  /// Facets chose their chains each for itself. Around a cell these may wind around a void of the
  /// mesh, and then bound nothing; cells hand on such windings until they are outside.
  void unwind() {
    const Voids voids(c_, e_, out_.embedding_[3]);
    if (voids.count() == 0) return;
    for (const auto& [cell, facet] : voids.exits()) {
      const auto windings = voids.windings(wantedBoundary<3>(cell));
      std::map<Index, double> chain(chainOf<2>(facet).begin(), chainOf<2>(facet).end());
      for (int k = 0; k < voids.count(); ++k) {
        const double winding = windings[static_cast<std::size_t>(k)];
        if (std::abs(winding) < kNoWeight) continue;
        for (const auto& [f, w] : voids.surface(k)) chain[f] -= signIn(cell, facet) * winding * w;
      }
      chainOf<2>(facet).assign(chain.begin(), chain.end());
    }
  }

  /// +1 when a facet points out of a cell of the expanded mesh.
  double signIn(Index cell, Index facet) const {
    for (const auto& [f, sign] : boundaryOf<3>(e_, cell)) {
      if (f == facet) return sign;
    }
    return 0;
  }

  /// false when there is no chain with the boundary that is asked for.
  template <int K>
  bool buildChain(Index simplex) {
    const std::map<Index, double> wanted = wantedBoundary<K>(simplex);
    const SparseChain guess = copies<K>(simplex);
    std::set<Index> around;
    for (const auto& [s, w] : wanted) {
      for (const Index v : verticesOf<K - 1>(c_, s)) around.insert(v);
    }
    for (const auto& [s, w] : guess) {
      for (const Index v : verticesOf<K>(c_, s)) around.insert(v);
    }
    // First the cells that lie between the simplices that are read, then all around them.
    for (int ring = 0;; ++ring) {
      std::map<Index, int> corners;
      for (const Index v : around) {
        c_.visitVertexStar(v, [&](const CellAtVertex& at) { ++corners[at.cell]; });
      }
      std::set<Index> cells;
      for (const auto& [cell, count] : corners) {
        if (ring > 0 || count > K) cells.insert(cell);
      }
      if (!cells.empty() && solve<K>(simplex, wanted, guess, cells) < kMissed) return true;
      if (ring == kMostRings || cells.size() == static_cast<std::size_t>(c_.cellCount())) {
        return false;
      }
      if (ring == 0) continue;
      for (const Index cell : cells) {
        for (const Index v : verticesOf<3>(c_, cell)) around.insert(v);
      }
    }
  }

  /// Finds the chain in a patch; returns by how much its boundary misses.
  template <int K>
  double solve(Index simplex, const std::map<Index, double>& wanted, const SparseChain& guess,
               const std::set<Index>& cells) {
    const auto columns = simplicesOf<K>(c_, cells), rows = simplicesOf<K - 1>(c_, cells);
    const auto m = static_cast<Eigen::Index>(rows.size()),
               n = static_cast<Eigen::Index>(columns.size());
    const Eigen::Index more = K == 1 ? 3 : 0;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(m + more, n);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(m + more), x = Eigen::VectorXd::Zero(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      for (const auto& [face, sign] : boundaryOf<K>(c_, columns[static_cast<std::size_t>(k)])) {
        a(placeIn(rows, face), k) += sign;
      }
    }
    for (const auto& [s, w] : wanted) {
      const Index row = placeIn(rows, s);
      if (row == kNone) return std::abs(w);  // outside the patch
      b[row] = w;
    }
    for (const auto& [s, w] : guess) {
      if (const Index column = placeIn(columns, s); column != kNone) x[column] = w;
    }
    if constexpr (K == 1) {
      // Constant fluxes have the potential 1/2 x_a x x_b: continued exactly, so are they. About a
      // near origin and in units of the edge's length, for rounding.
      const auto [from, to] = e_.edges[simplex];
      const Vec3 origin = x_[from];
      double size = (x_[to] - origin).norm();
      for (const Index s : columns) {
        size = std::max(size, (x_[c_.edges[s][1]] - x_[c_.edges[s][0]]).norm());
      }
      const auto potential = [&](Index p, Index q) {
        return Vec3((x_[p] - origin).cross(x_[q] - origin) / (2 * size * size));
      };
      for (Eigen::Index k = 0; k < n; ++k) {
        const auto& edge = c_.edges[columns[static_cast<std::size_t>(k)]];
        a.col(k).tail<3>() = potential(edge[0], edge[1]);
      }
      b.tail<3>() = potential(from, to);
    }
    x = nearest(a, b, x);
    SparseChain& chain = chainOf<K>(simplex);
    chain.clear();
    for (Eigen::Index k = 0; k < n; ++k) {
      if (std::abs(x[k]) > kNoWeight)
        chain.emplace_back(columns[static_cast<std::size_t>(k)], x[k]);
    }
    return (a * x - b).cwiseAbs().maxCoeff();
  }

  // ---- copies from parallel simplices of a lattice

  /// Sites of a simplex relative to its first vertex in stored order, and that vertex' site.
  template <int K>
  std::pair<std::vector<Int3>, Int3> shape(const Complex& c, Index simplex) const {
    std::vector<Int3> sites;
    for (const Index v : verticesOf<K>(c, simplex)) {
      sites.push_back(layer_.sites[static_cast<std::size_t>(v)]);
    }
    std::vector<Int3> sorted = sites;
    std::sort(sorted.begin(), sorted.end());
    const Int3 base = sorted[0];
    for (Int3& p : sorted) p = {p[0] - base[0], p[1] - base[1], p[2] - base[2]};
    return {sorted, base};
  }

  /// +1 when a simplex is stored in even order of its sites.
  template <int K>
  double parity(const Complex& c, Index simplex) const {
    const auto v = verticesOf<K>(c, simplex);
    double sign = 1;
    for (std::size_t i = 0; i < v.size(); ++i) {
      for (std::size_t j = i + 1; j < v.size(); ++j) {
        if (layer_.sites[static_cast<std::size_t>(v[j])] <
            layer_.sites[static_cast<std::size_t>(v[i])]) {
          sign = -sign;
        }
      }
    }
    return sign;
  }

  template <int K>
  void listBySites() {
    parallel_.clear();
    for (Index s = 0; s < c_.count(K); ++s) {
      const auto [sites, base] = shape<K>(c_, s);
      parallel_[sites].emplace_back(base, s);
    }
  }

  /// Mean of the nearest real simplices that a lattice translation brings to this one.
  template <int K>
  SparseChain copies(Index simplex) const {
    SparseChain result;
    if constexpr (K < 3) {
      if (layer_.sites.empty()) return result;
      const auto [sites, base] = shape<K>(e_, simplex);
      const auto found = parallel_.find(sites);
      if (found == parallel_.end()) return result;
      int least = 0;
      for (const auto& [at, s] : found->second) {
        int distance = 0;
        for (int k = 0; k < 3; ++k) distance += (at[k] - base[k]) * (at[k] - base[k]);
        if (!result.empty() && distance > least) continue;
        if (distance < least) result.clear();
        least = distance;
        result.emplace_back(s, parity<K>(c_, s) * parity<K>(e_, simplex));
      }
      for (auto& [s, w] : result) w /= static_cast<double>(result.size());
    }
    return result;
  }

  void keep(int degree) {
    std::vector<std::uint8_t> real(chains_[degree].size(), 0);
    for (const Index s : out_.embedding_[degree]) real[static_cast<std::size_t>(s)] = 1;
    for (std::size_t s = 0; s < real.size(); ++s) {
      if (!real[s]) {
        out_.chains_[degree].emplace_back(static_cast<Index>(s), std::move(chains_[degree][s]));
      }
    }
  }

  const VirtualLayer& layer_;
  const Array<Vec3>& x_;
  const Complex &c_, &e_;
  Extension& out_;
  std::vector<SparseChain> chains_[4];  // of all simplices of the expanded mesh
  std::map<std::vector<Int3>, std::vector<std::pair<Int3, Index>>> parallel_;
};

Extension::Extension(const ControlMesh& mesh, const VirtualLayer& layer,
                     const ControlMesh& expanded)
    : expanded_(expanded.complex()) {
  Builder(mesh, layer, expanded, this);
}

template <int K>
Cochain<K> Extension::apply(const Cochain<K>& form) const {
  Cochain<K> result(*expanded_);
  for (std::size_t s = 0; s < embedding_[K].size(); ++s) {
    result[embedding_[K][s]] = form[static_cast<Index>(s)];
  }
  for (const auto& [simplex, chain] : chains_[K]) {
    double sum = 0;
    for (const auto& [s, w] : chain) sum += w * form[s];
    result[simplex] = sum;
  }
  return result;
}

template Cochain<0> Extension::apply(const Cochain<0>&) const;
template Cochain<1> Extension::apply(const Cochain<1>&) const;
template Cochain<2> Extension::apply(const Cochain<2>&) const;
template Cochain<3> Extension::apply(const Cochain<3>&) const;

}  // namespace octet
