// SPDX-License-Identifier: Apache-2.0
#include "wall_potential.h"

#include <Eigen/Dense>
#include <algorithm>

#include "../base/disjoint_sets.h"
#include "../base/error.h"
#include "../base/sort_unique.h"

namespace octet {
namespace {

/// A closed part's flux may miss 0 by this much, relative to what passes through it.
constexpr double kBalanced = 1e-9;

/// Finds the parametrisation; the steps in order.
class Builder {
 public:
  Builder(const Complex& complex, const GivenFlux& flux) : c_(complex), flux_(flux) {}

  WallPotential build() {
    listConstraints();
    growVertexTree();
    growFacetTree();
    numberUnknowns();
    expandFacets();
    return finish();
  }

 private:
  enum class Role : std::uint8_t { Free, Tree, Pivot };

  void listConstraints() {
    facetsAtEdge_.resize(static_cast<std::size_t>(c_.edgeCount()));
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!flux_[f]) continue;
      given_.push_back(f);
      for (const EdgeRef& e : c_.facetEdges[f]) facetsAtEdge_[e.index()].push_back(f);
    }
    roles_.assign(static_cast<std::size_t>(c_.edgeCount()), Role::Free);
  }

  bool onWall(Index edge) const { return !facetsAtEdge_[edge].empty(); }

  void growVertexTree() {
    DisjointSets sets(c_.vertexCount());
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      if (onWall(e) && sets.join(c_.edges[e][0], c_.edges[e][1])) roles_[e] = Role::Tree;
    }
  }

  /// Gives every facet an edge that follows from its other two: towards the rim, where there is
  /// one. The first facet of a part without rim gets none; its equation follows from the others.
  void growFacetTree() {
    pivots_.assign(static_cast<std::size_t>(c_.facetCount()), kNone);
    std::vector<std::uint8_t> reached(static_cast<std::size_t>(c_.facetCount()), 0);
    std::size_t next = 0;
    const auto grow = [&] {
      for (; next < order_.size(); ++next) {
        for (const EdgeRef& e : c_.facetEdges[order_[next]]) {
          const auto& beside = facetsAtEdge_[e.index()];
          if (roles_[e.index()] != Role::Free || beside.size() != 2) continue;
          const Index other = beside[0] == order_[next] ? beside[1] : beside[0];
          if (reached[other]) continue;
          reached[other] = 1;
          pivots_[other] = e.index();
          roles_[e.index()] = Role::Pivot;
          order_.push_back(other);
        }
      }
    };
    for (const Index f : given_) {
      for (const EdgeRef& e : c_.facetEdges[f]) {
        const bool rim = facetsAtEdge_[e.index()].size() == 1 && roles_[e.index()] == Role::Free;
        if (!rim || reached[f]) continue;
        reached[f] = 1;
        pivots_[f] = e.index();
        roles_[e.index()] = Role::Pivot;
        order_.push_back(f);
      }
    }
    grow();
    for (const Index f : given_) {
      if (reached[f]) continue;
      reached[f] = 1;
      order_.push_back(f);
      grow();
    }
  }

  void numberUnknowns() {
    unknowns_.assign(static_cast<std::size_t>(c_.edgeCount()), kNone);
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      if (roles_[e] == Role::Free) unknowns_[e] = unknownCount_++;
    }
    expressions_.resize(static_cast<std::size_t>(c_.edgeCount()));
    constants_.setZero(c_.edgeCount());
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      if (unknowns_[e] != kNone) expressions_[e] = {{unknowns_[e], 1.0}};
    }
  }

  using Expression = std::vector<std::pair<Index, double>>;  // ascending unknowns

  static void add(Expression* to, const Expression& terms, double factor) {
    Expression sum;
    auto a = to->begin();
    auto b = terms.begin();
    while (a != to->end() || b != terms.end()) {
      if (b == terms.end() || (a != to->end() && a->first < b->first)) {
        sum.push_back(*a++);
      } else if (a == to->end() || b->first < a->first) {
        sum.emplace_back(b->first, factor * b->second);
        ++b;
      } else {
        const double w = a->second + factor * b->second;
        if (w != 0) sum.emplace_back(a->first, w);
        ++a;
        ++b;
      }
    }
    *to = std::move(sum);
  }

  /// From the leaves of the facet tree to its roots.
  void expandFacets() {
    for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
      const Index f = *it, pivot = pivots_[f];
      Expression sum;
      double constant = -*flux_[f], sign = 1;
      for (const EdgeRef& e : c_.facetEdges[f]) {
        if (e.index() == pivot) {
          sign = e.sign();
          continue;
        }
        add(&sum, expressions_[e.index()], e.sign());
        constant += e.sign() * constants_[e.index()];
      }
      if (pivot == kNone) {
        leftOver_.push_back({std::move(sum), constant});
        continue;
      }
      for (auto& term : sum) term.second *= -sign;
      expressions_[pivot] = std::move(sum);
      constants_[pivot] = -sign * constant;
    }
  }

  /// What the roots' equations still ask for: nothing but balance, unless the boundary touches
  /// itself in an edge.
  WallPotential finish() {
    double scale = 0;
    for (const Index f : given_) scale += std::abs(*flux_[f]);
    std::vector<std::pair<Expression, double>> open;
    std::vector<Index> involved;
    for (const auto& [sum, constant] : leftOver_) {
      if (sum.empty()) {
        if (std::abs(constant) > kBalanced * scale) {
          throw InputError("given flux", "a closed part of the boundary lets " +
                                             std::to_string(-constant) +
                                             " more out than in; a divergence-free field cannot");
        }
        continue;
      }
      open.emplace_back(sum, constant);
      for (const auto& term : sum) involved.push_back(term.first);
    }
    std::vector<Eigen::Triplet<double>> entries;
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      for (const auto& [k, w] : expressions_[e]) entries.emplace_back(e, k, w);
    }
    WallPotential result;
    result.basis.resize(c_.edgeCount(), unknownCount_);
    result.basis.setFromTriplets(entries.begin(), entries.end());
    result.particular = constants_;
    if (!open.empty()) eliminate(open, std::move(involved), &result);
    result.gaugeVertices.assign(static_cast<std::size_t>(c_.vertexCount()), 1);
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      if (!onWall(e)) continue;
      for (const Index v : c_.edges[e]) result.gaugeVertices[v] = 0;
    }
    return result;
  }

  /// Restricts the involved unknowns to the solutions of the equations that are left.
  void eliminate(const std::vector<std::pair<Expression, double>>& open,
                 std::vector<Index> involved, WallPotential* result) const {
    sortUnique(&involved);
    const auto rows = static_cast<Eigen::Index>(open.size());
    const auto columns = static_cast<Eigen::Index>(involved.size());
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, columns);
    Eigen::VectorXd right(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const auto& [sum, constant] = open[static_cast<std::size_t>(r)];
      right[r] = -constant;
      for (const auto& [k, w] : sum) {
        m(r, std::lower_bound(involved.begin(), involved.end(), k) - involved.begin()) = w;
      }
    }
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(m);
    const Eigen::VectorXd fixed = lu.solve(right);
    if ((m * fixed - right).cwiseAbs().maxCoeff() > kBalanced * (1 + right.cwiseAbs().maxCoeff())) {
      throw InputError("given flux", "does not add up to 0 on a closed part of the boundary");
    }
    const bool onlyZero = lu.rank() == columns;
    const Eigen::MatrixXd kernel = onlyZero ? Eigen::MatrixXd(columns, 0) : lu.kernel();
    std::vector<Eigen::Triplet<double>> entries;
    Index next = 0;
    Eigen::VectorXd shift = Eigen::VectorXd::Zero(unknownCount_);
    for (Index k = 0; k < unknownCount_; ++k) {
      if (!std::binary_search(involved.begin(), involved.end(), k)) {
        entries.emplace_back(k, next++, 1.0);
      }
    }
    for (Eigen::Index r = 0; r < columns; ++r) {
      const Index k = involved[static_cast<std::size_t>(r)];
      shift[k] = fixed[r];
      for (Eigen::Index z = 0; z < kernel.cols(); ++z) {
        if (kernel(r, z) != 0) entries.emplace_back(k, next + static_cast<Index>(z), kernel(r, z));
      }
    }
    Eigen::SparseMatrix<double> selection(unknownCount_, next + static_cast<Index>(kernel.cols()));
    selection.setFromTriplets(entries.begin(), entries.end());
    result->particular += result->basis * shift;
    result->basis = (result->basis * selection).eval();
  }

  const Complex& c_;
  const GivenFlux& flux_;
  std::vector<Index> given_, order_, pivots_, unknowns_;
  std::vector<std::vector<Index>> facetsAtEdge_;
  std::vector<Role> roles_;
  Index unknownCount_ = 0;
  std::vector<Expression> expressions_;
  Eigen::VectorXd constants_;
  std::vector<std::pair<Expression, double>> leftOver_;
};

}  // namespace

WallPotential makeWallPotential(const Complex& complex, const GivenFlux& flux) {
  return Builder(complex, flux).build();
}

}  // namespace octet
