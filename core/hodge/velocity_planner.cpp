// SPDX-License-Identifier: Apache-2.0
#include "velocity_planner.h"

#include <cmath>
#include <mutex>
#include <tuple>

#include "../forms/coboundary.h"
#include "mass_matrix.h"

namespace octet {
namespace {

/// Net fluxes through a piece of the boundary below this part of the whole are rounding.
constexpr double kNoFlux = 1e-8;

bool vanishesOnBoundary(const Complex& c, const Cochain<1>& form) {
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (c.edgeOnBoundary(e) && form[e] != 0) return false;
  }
  return true;
}

bool hasClosedWalls(const Complex& c, const Cochain<2>& form) {
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetOnBoundary(f) && form[f] != 0) return false;
  }
  return true;
}

/// The net fluxes through pieces of the boundary, but for rounding.
std::vector<LeavesVoid::NetFlux> netFluxes(const ControlMesh& mesh, const Cochain<2>& velocity) {
  const Complex& c = *mesh.complex();
  std::vector<LeavesVoid::NetFlux> result;
  for (const BoundaryPiece& piece : boundaryFluxes(c, velocity)) {
    if (std::abs(piece.flux) <= kNoFlux * piece.through) continue;
    result.push_back({piece.flux, mesh.positions()[c.facetVertices(piece.facet)[0]]});
  }
  return result;
}

template <int K>
double energy(const Eigen::SparseMatrix<double>& mass, const Cochain<K>& form) {
  const Eigen::Map<const Eigen::VectorXd> x(form.data(), form.size());
  return x.dot(mass * x);
}

}  // namespace

struct VelocityPlanner::Solvers {
  template <int K>
  struct Projector {
    std::vector<std::uint8_t> fixed;
    ClosedProjection<K> projection;
    Eigen::SparseMatrix<double> mass;
  };

  explicit Solvers(const ControlMesh& mesh) : potentials(*mesh.complex(), mesh.positions()) {}

  /// The projector for these fixed coefficients; the last one is kept.
  template <int K>
  std::shared_ptr<const Projector<K>> projector(const ControlMesh& mesh,
                                                const std::vector<std::uint8_t>& fixed,
                                                const Context& context) {
    const std::lock_guard<std::mutex> lock(mutex);
    auto& last = std::get<std::shared_ptr<const Projector<K>>>(projectors);
    if (!last || last->fixed != fixed) {
      const Complex& c = *mesh.complex();
      last = std::make_shared<const Projector<K>>(
          Projector<K>{fixed, ClosedProjection<K>(c, mesh.positions(), fixed, context),
                       massMatrix<K>(c, mesh.positions())});
    }
    return last;
  }

  PotentialSolver potentials;
  std::mutex mutex;
  std::tuple<std::shared_ptr<const Projector<1>>, std::shared_ptr<const Projector<2>>> projectors;
};

VelocityPlanner::VelocityPlanner(const ControlMesh& mesh)
    : mesh_(mesh), solvers_(std::make_unique<Solvers>(mesh)) {}
VelocityPlanner::~VelocityPlanner() = default;

VelocityPlan VelocityPlanner::plan(const Cochain<2>& velocity, const Cochain<1>* given,
                                   const Context& context) const {
  const Complex& c = *mesh_.complex();
  const bool closedWalls = hasClosedWalls(c, velocity);
  if (given && (!closedWalls || vanishesOnBoundary(c, *given))) {
    return {VectorPotential{*given, vanishesOnBoundary(c, *given)}, std::nullopt};
  }
  VelocityPlan result;
  if (auto open = whereOpen(velocity)) {
    result.flaw = std::move(*open);
    return result;
  }
  result.potential = solvers_->potentials.find(velocity, context);
  if (!result.potential) {
    result.flaw = LeavesVoid{netFluxes(mesh_, velocity)};
  } else if (closedWalls && !result.potential->zeroOnBoundary) {
    result.flaw = AroundHandle{};
  }
  return result;
}

template <int K>
std::optional<NotClosed> VelocityPlanner::whereOpen(const Cochain<K>& form) const {
  const Complex& c = *mesh_.complex();
  const Openness open = openness(c, form);
  if (open.relative <= kClosedTolerance) return std::nullopt;
  NotClosed result{K, open.largest, open.relative};
  if constexpr (K == 2) {
    const int n = c.cellVertexCount(open.at);
    for (int i = 0; i < n; ++i) {
      result.centre += mesh_.positions()[c.cellVertex(open.at, i)] / n;
    }
    result.simplex = ControlMesh::cellName(c, open.at);
  } else {
    const auto v = c.facetVertices(open.at);
    for (const Index i : v) result.centre += mesh_.positions()[i] / 3;
    result.simplex = "facet (" + std::to_string(v[0]) + ", " + std::to_string(v[1]) + ", " +
                     std::to_string(v[2]) + ")";
  }
  return result;
}

template <int K>
ClosedForm<K> VelocityPlanner::closest(const Cochain<K>& form, const Context& context) const {
  const Complex& c = *mesh_.complex();
  const auto open = whereOpen(form);
  if (!open) return {form, std::nullopt};
  std::vector<std::uint8_t> fixed = onBoundary<K>(c);
  for (Index k = 0; k < form.size(); ++k) fixed[k] = fixed[k] && form[k] == 0;
  const auto projector = solvers_->projector<K>(mesh_, fixed, context);
  ClosedForm<K> result{projector->projection.apply(form, false, context), open};
  Cochain<K> change = result.form;
  for (Index k = 0; k < form.size(); ++k) change[k] -= form[k];
  result.changed = std::sqrt(energy(projector->mass, change) / energy(projector->mass, form));
  return result;
}

template ClosedForm<1> VelocityPlanner::closest(const Cochain<1>&, const Context&) const;
template ClosedForm<2> VelocityPlanner::closest(const Cochain<2>&, const Context&) const;
template std::optional<NotClosed> VelocityPlanner::whereOpen(const Cochain<1>&) const;
template std::optional<NotClosed> VelocityPlanner::whereOpen(const Cochain<2>&) const;

}  // namespace octet
