// SPDX-License-Identifier: Apache-2.0
#include "bake_facts.h"

#include <cmath>

#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/with_degree.h>
#include <octet/core/topology/mean_edge.h>

namespace octet {
namespace {

/// Sums of coefficients this small, relative to the largest, are rounding.
constexpr double kCancelled = 1e-14;

}  // namespace

MeshFacts findMeshFacts(const ControlAsset& asset, const BakeOptions& bake,
                        const Context& context) {
  const ControlMesh& mesh = asset.mesh;
  RefinerOptions options;
  options.levels = 1;
  options.zeta = bake.zeta;
  options.boundaryRows = bake.wallSurface;
  context.poll();  // one level is quick, and not of what is reported
  const Refiner refiner(mesh, options);
  const Limit limit(refiner);
  MeshFacts facts;
  facts.controlEdge = meanEdge(*mesh.complex(), mesh.positions());
  facts.turn = turnFor(asset.units.upAxis, bake);
  facts.domain = DomainShape(refiner.finest(), limit.positions(), facts.turn);
  facts.longestSide = facts.domain.box().size().maxCoeff();
  facts.firstEdge = meanEdge(refiner.finest(), limit.positions());
  facts.tets = static_cast<double>(mesh.complex()->tetCount());
  facts.octs = static_cast<double>(mesh.complex()->octCount());
  return facts;
}

RefinementFacts describe(const Subdivision& subdivision, double fineEdge) {
  return {fineEdge, subdivision.hasLimits(), subdivision.commutes(), subdivision.note(),
          subdivision.boundaryRule()};
}

ControlForms::ControlForms(const ControlAsset& asset, const BakeOptions& options)
    : asset_(asset), options_(options), planner_(asset.mesh) {}

ControlForm ControlForms::find(const Form& form, const std::string& grid, std::optional<int> frame,
                               const BakeFacts& facts, const Context& context) const {
  ControlForm result;
  result.facts.name = form.name;
  result.facts.unit = form.unit;
  result.facts.grid = grid;
  result.facts.mode = mode(form);
  withDegree(form.degree, [&](auto degree) {
    constexpr int K = decltype(degree)::value;
    const int number = frame.value_or(0);
    if constexpr (K < 3) {
      if (options_.derivative) {
        const auto given = coefficients<K>(asset_, form, number);
        take<K + 1>(derivative<K>(form, number), &given, facts, &result, context);
        return;
      }
    }
    auto control = coefficients<K>(asset_, form, number);
    if constexpr (K == 1 || K == 2) {
      if (options_.project) {
        auto closed = planner_.closest(control, context);
        control = std::move(closed.form);
        if (closed.was) result.facts.projected = Projected{*closed.was, closed.changed};
      }
    }
    take<K>(std::move(control), nullptr, facts, &result, context);
  });
  return result;
}

BoundaryMode ControlForms::mode(const Form& form) const {
  if (!options_.derivative) return boundaryMode(asset_, form, options_.boundary);
  return withDegree(form.degree, [&](auto degree) {
    constexpr int K = decltype(degree)::value;
    if constexpr (K < 3) {
      return derivativeMode<K>(form);
    } else {
      return BoundaryMode::Walls;
    }
  });
}

/// Puts coefficients and what there is to know of them into the result.
/// @param given  a potential of the control form, or null
template <int K>
void ControlForms::take(Cochain<K> control, const Cochain<K - 1>* given, const BakeFacts& facts,
                        ControlForm* result, const Context& context) const {
  result->facts.degree = K;
  if constexpr (K == 1 || K == 2) {
    if (seeksPotential(K, options_, facts)) {
      findPotential(control, given, result, context);
    } else {
      result->facts.open = planner_.whereOpen(control);
    }
  }
  result->form = std::move(control);
}

void ControlForms::findPotential(const Cochain<1>& control, const Cochain<0>* given,
                                 ControlForm* result, const Context& context) const {
  context.poll();
  auto potential = given ? *given : scalarPotential(*asset_.mesh.complex(), control);
  result->facts.hasPotential = potential.has_value();
  if (potential) {
    result->potential = std::move(*potential);
  } else if (const auto open = planner_.whereOpen(control)) {
    result->facts.flaw = *open;
  }
}

void ControlForms::findPotential(const Cochain<2>& control, const Cochain<1>* given,
                                 ControlForm* result, const Context& context) const {
  VelocityPlan plan = planner_.plan(control, given, context);
  result->facts.hasPotential = plan.potential.has_value();
  result->facts.flaw = std::move(plan.flaw);
  if (plan.potential) result->potential = std::move(plan.potential->form);
}

/// The derivative on the control mesh; coefficients that cancel up to rounding are 0.
template <int K>
Cochain<K + 1> ControlForms::derivative(const Form& form, int frame) const {
  Cochain<K + 1> result = d(*asset_.mesh.complex(), coefficients<K>(asset_, form, frame));
  const double scale = maxNorm(result.values());
  for (double& x : result.values()) {
    if (std::abs(x) < kCancelled * scale) x = 0;
  }
  return result;
}

/// One mode for all frames, as the derivative's own boundary says.
template <int K>
BoundaryMode ControlForms::derivativeMode(const Form& form) const {
  if (options_.boundary.mode) return *options_.boundary.mode;
  std::vector<int> frames = {0};
  if (form.animated()) frames.clear();
  for (const auto& [number, values] : form.frames) frames.push_back(number);
  for (const int number : frames) {
    if (automaticMode(*asset_.mesh.complex(), derivative<K>(form, number)) == BoundaryMode::Open) {
      return BoundaryMode::Open;
    }
  }
  return BoundaryMode::Walls;
}

}  // namespace octet
