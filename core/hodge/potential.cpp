// SPDX-License-Identifier: Apache-2.0
#include "potential.h"

#include <cmath>
#include <map>
#include <mutex>

#include "../base/disjoint_sets.h"
#include "../forms/coboundary.h"
#include "coboundary_matrix.h"
#include "constrained_minimum.h"
#include "free_columns.h"
#include "mass_matrix.h"
#include "projection.h"

namespace octet {
namespace {

/// Largest |d A - w| over the largest |w| that is rounding; forms that count as closed may leave
/// their own openness over.
constexpr double kExact = 1e-8;

}  // namespace

template <int K>
Openness openness(const Complex& complex, const Cochain<K>& form) {
  Openness result;
  const auto derivative = d(complex, form);
  for (Index k = 0; k < derivative.size(); ++k) {
    if (std::abs(derivative[k]) <= result.largest) continue;
    result.largest = std::abs(derivative[k]);
    result.at = k;
  }
  const double scale = maxNorm(form.values());
  if (scale > 0) result.relative = result.largest / scale;
  return result;
}
template Openness openness(const Complex&, const Cochain<1>&);
template Openness openness(const Complex&, const Cochain<2>&);

std::vector<BoundaryPiece> boundaryFluxes(const Complex& complex, const Cochain<2>& form) {
  form.checkOn(complex);
  DisjointSets sets(complex.facetCount());
  std::vector<Index> facetOfEdge(static_cast<std::size_t>(complex.edgeCount()), kNone);
  for (Index f = 0; f < complex.facetCount(); ++f) {
    if (!complex.facetOnBoundary(f)) continue;
    for (const EdgeRef& e : complex.facetEdges[f]) {
      Index& other = facetOfEdge[e.index()];
      if (other != kNone) sets.join(f, other);
      other = f;
    }
  }
  std::map<Index, BoundaryPiece> pieces;
  for (Index f = 0; f < complex.facetCount(); ++f) {
    if (!complex.facetOnBoundary(f)) continue;
    BoundaryPiece& piece = pieces.emplace(sets.find(f), BoundaryPiece{f, 0, 0}).first->second;
    piece.flux += complex.facetCells[f][0].exists() ? form[f] : -form[f];
    piece.through += std::abs(form[f]);
  }
  std::vector<BoundaryPiece> result;
  for (const auto& [root, piece] : pieces) result.push_back(piece);
  return result;
}

/// d A = w among the A that are 0 on some edges.
struct PotentialSolver::Systems {
  struct System {
    System(const Complex& complex, const Array<Vec3>& positions,
           const std::vector<std::uint8_t>& fixed, const Context& context)
        : free(complex.edgeCount(), fixed),
          minimum(free.block(massMatrix<1>(complex, positions)),
                  free.columns(coboundaryMatrix<1>(complex)), context) {}
    FreeColumns free;
    ConstrainedMinimum minimum;
  };

  std::optional<Cochain<1>> solve(std::unique_ptr<System> Systems::*which,
                                  const std::vector<std::uint8_t>& fixed, const Cochain<2>& w,
                                  const Context& context) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (!(this->*which)) this->*which = std::make_unique<System>(c, x, fixed, context);
    }
    const System& system = *(this->*which);
    const Eigen::Map<const Eigen::VectorXd> right(w.data(), w.size());
    const auto solution =
        system.minimum.solve(Eigen::VectorXd::Zero(system.free.count()), right, context);
    if (solution.residual > kExact * maxNorm(w.values())) return std::nullopt;
    Cochain<1> result(c);
    system.free.add(solution.x, result.data());
    return result;
  }

  const Complex& c;
  const Array<Vec3>& x;
  std::mutex mutex;
  std::unique_ptr<System> relative, absolute;
};

PotentialSolver::PotentialSolver(const Complex& complex, const Array<Vec3>& positions)
    : systems_(new Systems{complex, positions, {}, nullptr, nullptr}) {}
PotentialSolver::~PotentialSolver() = default;
PotentialSolver::PotentialSolver(PotentialSolver&&) noexcept = default;

std::optional<VectorPotential> PotentialSolver::find(const Cochain<2>& form,
                                                     const Context& context) const {
  const Complex& c = systems_->c;
  if (openness(c, form).relative > kClosedTolerance) return std::nullopt;
  bool closedWalls = true;
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f) && form[f] != 0) closedWalls = false;
  }
  if (closedWalls) {
    if (auto a = systems_->solve(&Systems::relative, onBoundary<1>(c), form, context)) {
      return VectorPotential{std::move(*a), true};
    }
  }
  if (auto a = systems_->solve(&Systems::absolute, {}, form, context)) {
    return VectorPotential{std::move(*a), false};
  }
  return std::nullopt;
}

std::optional<Cochain<0>> scalarPotential(const Complex& complex, const Cochain<1>& form) {
  form.checkOn(complex);
  // Edges at each vertex.
  std::vector<std::vector<EdgeRef>> edges(static_cast<std::size_t>(complex.vertexCount()));
  for (Index e = 0; e < complex.edgeCount(); ++e) {
    edges[complex.edges[e][0]].emplace_back(e, false);
    edges[complex.edges[e][1]].emplace_back(e, true);
  }
  Cochain<0> result(complex);
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(complex.vertexCount()), 0);
  for (Index root = 0; root < complex.vertexCount(); ++root) {
    if (seen[root]) continue;
    std::vector<Index> part = {root};
    seen[root] = 1;
    double sum = 0;
    for (std::size_t k = 0; k < part.size(); ++k) {
      const Index v = part[k];
      sum += result[v];
      for (const EdgeRef& e : edges[v]) {
        const Index next = complex.edges[e.index()][e.reversed() ? 0 : 1];
        if (seen[next]) continue;
        seen[next] = 1;
        result[next] = result[v] + form.at(e);
        part.push_back(next);
      }
    }
    for (const Index v : part) result[v] -= sum / static_cast<double>(part.size());
  }
  const auto derivative = d(complex, result);
  const double tolerance = kExact * maxNorm(form.values());
  for (Index e = 0; e < complex.edgeCount(); ++e) {
    if (std::abs(derivative[e] - form[e]) > tolerance) return std::nullopt;
  }
  return result;
}

}  // namespace octet
