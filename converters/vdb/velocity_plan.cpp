// SPDX-License-Identifier: Apache-2.0
#include "velocity_plan.h"

#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <mutex>
#include <tuple>

#include <octet/core/forms/coboundary.h>
#include <octet/core/hodge/mass_matrix.h>

namespace octet {
namespace {

/// Net fluxes through a piece of the boundary below this part of the whole are rounding.
constexpr double kNoFlux = 1e-8;

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[400];
  std::va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string at(const Vec3& p) { return format("(%.4g, %.4g, %.4g)", p[0], p[1], p[2]); }

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
                                                const std::vector<std::uint8_t>& fixed) {
    const std::lock_guard<std::mutex> lock(mutex);
    auto& last = std::get<std::shared_ptr<const Projector<K>>>(projectors);
    if (!last || last->fixed != fixed) {
      const Complex& c = *mesh.complex();
      last = std::make_shared<const Projector<K>>(
          Projector<K>{fixed, ClosedProjection<K>(c, mesh.positions(), fixed),
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

VelocityPlan VelocityPlanner::plan(const Cochain<2>& velocity, const Cochain<1>* given) const {
  const Complex& c = *mesh_.complex();
  const bool closedWalls = hasClosedWalls(c, velocity);
  if (given && (!closedWalls || vanishesOnBoundary(c, *given))) {
    return {VectorPotential{*given, vanishesOnBoundary(c, *given)}, ""};
  }
  VelocityPlan result;
  result.note = describeOpenness(velocity);
  if (!result.note.empty()) return result;
  result.potential = solvers_->potentials.find(velocity);
  if (!result.potential) {
    for (const BoundaryPiece& piece : boundaryFluxes(c, velocity)) {
      if (std::abs(piece.flux) <= kNoFlux * piece.through) continue;
      const Index v = c.facetVertices(piece.facet)[0];
      result.note +=
          format("%sa net flux of %.4g leaves through the boundary near %s",
                 result.note.empty() ? "" : ", ", piece.flux, at(mesh_.positions()[v]).c_str());
    }
    result.note += std::string(result.note.empty() ? "" : ": ") +
                   "the flow has no vector potential: it leaves a void of the domain";
  } else if (closedWalls && !result.potential->zeroOnBoundary) {
    result.note =
        "the flow circulates through a handle of the domain; voxels cut by walls are left "
        "out";
  }
  return result;
}

template <int K>
std::string VelocityPlanner::describeOpenness(const Cochain<K>& form) const {
  const Complex& c = *mesh_.complex();
  const Openness open = openness(c, form);
  if (open.relative <= kClosedTolerance) return "";
  Vec3 centre = Vec3::Zero();
  std::string name;
  if constexpr (K == 2) {
    const int n = c.cellVertexCount(open.at);
    for (int i = 0; i < n; ++i) centre += mesh_.positions()[c.cellVertex(open.at, i)] / n;
    name = ControlMesh::cellName(c, open.at);
  } else {
    const auto v = c.facetVertices(open.at);
    for (const Index i : v) centre += mesh_.positions()[i] / 3;
    name = format("facet (%d, %d, %d)", v[0], v[1], v[2]);
  }
  return format("not closed: %.4g, or %.3g of the largest coefficient, %s %s at %s", open.largest,
                open.relative, K == 2 ? "leaves" : "runs around", name.c_str(), at(centre).c_str());
}

template <int K>
ClosedForm<K> VelocityPlanner::closest(const Cochain<K>& form) const {
  const Complex& c = *mesh_.complex();
  const std::string open = describeOpenness(form);
  if (open.empty()) return {form, ""};
  std::vector<std::uint8_t> fixed = onBoundary<K>(c);
  for (Index k = 0; k < form.size(); ++k) fixed[k] = fixed[k] && form[k] == 0;
  const auto projector = solvers_->projector<K>(mesh_, fixed);
  ClosedForm<K> result{projector->projection.apply(form), ""};
  Cochain<K> change = result.form;
  for (Index k = 0; k < form.size(); ++k) change[k] -= form[k];
  const double part = std::sqrt(energy(projector->mass, change) / energy(projector->mass, form));
  result.note =
      "projected: changed by " + format("%.3g", 100 * part) + " % of its norm; was " + open;
  return result;
}

template ClosedForm<1> VelocityPlanner::closest(const Cochain<1>&) const;
template ClosedForm<2> VelocityPlanner::closest(const Cochain<2>&) const;
template std::string VelocityPlanner::describeOpenness(const Cochain<1>&) const;
template std::string VelocityPlanner::describeOpenness(const Cochain<2>&) const;

}  // namespace octet
