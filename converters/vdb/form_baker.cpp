// SPDX-License-Identifier: Apache-2.0
#include "form_baker.h"

#include <cmath>
#include <cstdio>

#include <octet/core/base/error.h>
#include <octet/core/base/parallel.h>
#include <octet/core/field/vertex_field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/with_degree.h>
#include <octet/core/hodge/flux_rasterizer.h>
#include <octet/core/topology/mean_edge.h>

namespace octet {
namespace {

/// Sums of coefficients this small, relative to the largest, are rounding.
constexpr double kCancelled = 1e-14;

char orElse(char axis, char other) { return axis ? axis : other; }

}  // namespace

FormBaker::FormBaker(const ControlAsset& asset, const BakeOptions& options, const Target& target,
                     const GridChoice& grid)
    : asset_(asset),
      options_(options),
      target_(target),
      grid_(grid),
      turn_{asset.units.upAxis, orElse(target.upAxis, asset.units.upAxis)},
      planner_(asset.mesh) {
  RefinerOptions refinerOptions;
  refinerOptions.levels = grid.levels;
  refinerOptions.zeta = options.zeta;
  refinerOptions.progress = options.progress;
  refinement_ = options.boundary.subdivide(asset.mesh, refinerOptions);
  voxelsPerEdge_ = grid.voxelSize / finestEdge();
  checkMethod();
}

FormBaker::~FormBaker() = default;

double FormBaker::finestEdge() const { return meanEdge(finest(), refinement_->limitPositions()); }

void FormBaker::Job::say(const std::string& more) {
  if (!more.empty()) note += (note.empty() ? "" : "; ") + more;
}

VdbGridInfo FormBaker::bake(const Form& form, const std::string& gridName, std::optional<int> frame,
                            VdbFile* file) const {
  return withDegree(form.degree, [&](auto degree) {
    constexpr int K = decltype(degree)::value;
    const Job job{form, gridName, frame.value_or(0), file};
    if constexpr (K < 3) {
      if (options_.derivative) return bakeDerivative<K>(job);
    }
    return bakeForm<K>(job);
  });
}

template <int K>
VdbGridInfo FormBaker::bakeForm(Job job) const {
  job.mode = boundaryMode(asset_, job.form, options_.boundary);
  Cochain<K> control = coefficients<K>(asset_, job.form, job.frame);
  if constexpr (K == 1 || K == 2) {
    job.say(methodNote());
    if (options_.project) {
      auto closed = planner_.closest(control);
      control = std::move(closed.form);
      job.say(closed.note);
    }
  }
  if constexpr (K == 1) return addGradient(std::move(job), control, nullptr);
  if constexpr (K == 2) return addFlux(std::move(job), control, nullptr);
  return addSamples<K>(job, control);
}

/// d commutes with refinement: refining the derivative is differentiating the refined form.
template <int K>
VdbGridInfo FormBaker::bakeDerivative(Job job) const {
  job.mode = derivativeMode<K>(job.form);
  const Cochain<K + 1> control = derivative<K>(job.form, job.frame);
  if constexpr (K < 2) job.say(methodNote());
  if constexpr (K == 0) {
    const auto potential = coefficients<0>(asset_, job.form, job.frame);
    return addGradient(std::move(job), control, &potential);
  }
  if constexpr (K == 1) {
    const auto potential = coefficients<1>(asset_, job.form, job.frame);
    return addFlux(std::move(job), control, &potential);
  }
  return addSamples<K + 1>(job, control);
}

/// The derivative on the control mesh; coefficients that cancel up to rounding are 0.
template <int K>
Cochain<K + 1> FormBaker::derivative(const Form& form, int frame) const {
  Cochain<K + 1> result = d(*asset_.mesh.complex(), coefficients<K>(asset_, form, frame));
  const double scale = maxNorm(result.values());
  for (double& x : result.values()) {
    if (std::abs(x) < kCancelled * scale) x = 0;
  }
  return result;
}

/// One mode for all frames, as the derivative's own boundary says.
template <int K>
BoundaryMode FormBaker::derivativeMode(const Form& form) const {
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

/// A flux is baked from its vector potential, when it has one: by commutation the refined
/// potential's derivative is the refined form.
VdbGridInfo FormBaker::addFlux(Job job, const Cochain<2>& control, const Cochain<1>* given) const {
  const std::string worse = whyMeansAreWorse();
  if (!mayConserve() || !worse.empty()) {
    const std::string open = planner_.describeOpenness(control);
    job.say(open.empty() && mayConserve() ? worse : open);
    return addSamples<2>(job, control);
  }
  const VelocityPlan plan = planner_.plan(control, given);
  // With a potential, a note is about voxels that only staggered grids leave out.
  if (!plan.potential || options_.sampling == Sampling::Staggered) job.say(plan.note);
  if (plan.potential) return addCirculations(job, plan.potential->form, control);
  refuseSamples(job);
  return addSamples<2>(job, control);
}

VdbGridInfo FormBaker::addCirculations(const Job& job, const Cochain<1>& potential,
                                       const Cochain<2>& control) const {
  const Array<Vec3> vectors = turn_(refinement_->limitVectors(control, job.mode));
  const bool walls = job.mode == BoundaryMode::Walls && refinement_->boundaryRule().empty();
  PotentialField field(refinement_->finest(), turn_(refinement_->positions(grid_.levels)),
                       refinement_->refine(potential, job.mode), vectors, walls);
  if (options_.sampling == Sampling::Staggered) {
    return job.file->add(field, gridSpec<2>(job), options_.progress);
  }
  const VectorField samples(std::make_shared<VertexField<3>>(
      refinement_->finest(), turn_(refinement_->limitPositions()), vectors));
  const MeanFluxField means{samples, std::move(field), neighbourWeight(voxelsPerEdge_)};
  return job.file->add(means, gridSpec<2>(job), options_.progress);
}

/// A gradient is baked as differences of its potential, when it has one.
VdbGridInfo FormBaker::addGradient(Job job, const Cochain<1>& control,
                                   const Cochain<0>* given) const {
  std::optional<Cochain<0>> potential;
  if (mayConserve()) {
    potential = given ? *given : scalarPotential(*asset_.mesh.complex(), control);
  }
  if (!potential) {
    job.say(planner_.describeOpenness(control));
    refuseSamples(job);
    return addSamples<1>(job, control);
  }
  return job.file->add(gradientField(*potential, control, job.mode), gridSpec<1>(job),
                       options_.progress);
}

/// Potentials go with limits alone, and only where the derivative of a refined one is the refined
/// derivative: of the thesis' boundary methods, with expansion.
bool FormBaker::mayConserve() const {
  return options_.method != BakeMethod::Samples && limitFields() && refinement_->commutes();
}

void FormBaker::checkMethod() const {
  if (options_.method == BakeMethod::Conservative && !mayConserve()) {
    throw InputError("method",
                     "conservative needs the limit reconstruction, and a boundary that commutes "
                     "with d: auto, walls, open, or expansion where the mesh has no narrow gaps");
  }
}

/// Of a collocated grid, unless circulations are asked for; empty when they are no worse.
std::string FormBaker::whyMeansAreWorse() const {
  if (options_.sampling == Sampling::Staggered || options_.method == BakeMethod::Conservative ||
      (voxelsPerEdge_ >= kFinestMeans && voxelsPerEdge_ <= kCoarsestMeans)) {
    return "";
  }
  char text[120];
  std::snprintf(text, sizeof text,
                "voxels are %.2g fine edges: circulations are as accurate from %.2g to %.2g",
                voxelsPerEdge_, kFinestMeans, kCoarsestMeans);
  return text;
}

void FormBaker::refuseSamples(const Job& job) const {
  if (options_.method != BakeMethod::Conservative) return;
  throw InputError("form \"" + job.form.name + "\"",
                   "cannot be baked by method conservative: " +
                       (job.note.empty() ? "it has no potential" : job.note));
}

template <int K>
VdbGridInfo FormBaker::addSamples(const Job& job, const Cochain<K>& control) const {
  const auto field = makeField(*refinement_, control, job.mode, options_.reconstruction);
  return job.file->add(turnedField(field, refinement_->finest(), turn_), gridSpec<K>(job),
                       options_.progress);
}

GradientField FormBaker::gradientField(const Cochain<0>& potential, const Cochain<1>& control,
                                       BoundaryMode mode) const {
  const auto finest = refinement_->finest();
  const Array<Vec3>& positions = refinement_->limitPositions();
  const Array<double> values = refinement_->limitValues(potential, mode);
  Array<Vec3> vectors = refinement_->limitVectors(control, mode);
  Array<Piece<1>::Value> base(values.size());
  parallelFor<std::size_t>(values.size(), [&](std::size_t k) {
    base[k][0] = values[k] - vectors[k].dot(positions[k]) / 2;
  });
  const ScalarField baseField(std::make_shared<VertexField<1>>(finest, positions, std::move(base)));
  const VectorField vectorField(
      std::make_shared<VertexField<3>>(finest, positions, std::move(vectors)));
  return {turnedField(baseField, finest, turn_), turnedField(vectorField, finest, turn_)};
}

bool FormBaker::limitFields() const {
  return options_.reconstruction == Reconstruction::Limit && refinement_->hasLimits();
}

std::string FormBaker::methodNote() const {
  const std::string note = refinement_->note();
  if (note.empty() || options_.method == BakeMethod::Samples) return note;
  return note + "; sampled, as no refined potential has its derivative";
}

template <int K>
VdbGridSpec FormBaker::gridSpec(const Job& job) const {
  using Class = VdbGridSpec::Class;
  VdbGridSpec spec;
  spec.name = job.gridName;
  spec.note = job.note;
  spec.frame.voxelSize = grid_.voxelSize;
  spec.half = options_.half;
  if (target_.voxelCornered) spec.shift = Vec3::Constant(-grid_.voxelSize / 2);
  if constexpr (K == 1 || K == 2) {
    spec.sampling = options_.sampling;
    spec.vectorType = K == 1 ? VdbGridSpec::VectorType::Covariant
                             : VdbGridSpec::VectorType::ContravariantRelative;
    if (spec.sampling == Sampling::Staggered) spec.gridClass = Class::Staggered;
  }
  if (K == 3 || target_.fogClass) spec.gridClass = Class::Fog;
  const std::string rule = refinement_->boundaryRule();
  const char* const mode = job.mode == BoundaryMode::Walls ? "walls" : "open";
  spec.metadata = {{"octet_form", job.form.name},
                   {"octet_degree", static_cast<std::int32_t>(K)},
                   {"octet_derivative", static_cast<std::int32_t>(options_.derivative)},
                   {"octet_unit", job.form.unit},
                   {"octet_levels", static_cast<std::int32_t>(grid_.levels)},
                   {"octet_boundary", rule.empty() ? mode : rule},
                   {"octet_reconstruction", std::string(limitFields() ? "limit" : "whitney")}};
  return spec;
}

}  // namespace octet
