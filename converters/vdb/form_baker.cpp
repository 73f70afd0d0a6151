// SPDX-License-Identifier: Apache-2.0
#include "form_baker.h"

#include <octet/core/field/vertex_field.h>
#include <octet/core/forms/with_degree.h>
#include <octet/core/topology/mean_edge.h>

#include "wording.h"

namespace octet {

FormBaker::FormBaker(const ControlMesh& mesh, const BakeOptions& options, int levels,
                     const Context& context)
    : options_(options), target_(findTarget(options.target)) {
  RefinerOptions refinerOptions;
  refinerOptions.levels = levels;
  refinerOptions.zeta = options.zeta;
  refinerOptions.boundaryRows = options.wallSurface;
  refinement_ = options.boundary.subdivide(mesh, refinerOptions, context);
}

RefinementFacts FormBaker::facts() const {
  return describe(*refinement_, meanEdge(finest(), refinement_->limitPositions()));
}

VdbGridInfo FormBaker::execute(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                               const Context& context) const {
  switch (plan.method) {
    case GridMethod::Circulations:
      return addCirculations(plan, control, file, context);
    case GridMethod::Differences:
      return addDifferences(plan, control, file, context);
    case GridMethod::Samples:
    case GridMethod::None:
      break;
  }
  return withDegree(plan.degree, [&](auto degree) {
    return addSamples<decltype(degree)::value>(plan, control, file, context);
  });
}

template <int K>
VdbGridInfo FormBaker::addSamples(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                                  const Context& context) const {
  const auto field =
      makeField(*refinement_, control.as<K>(), plan.mode, plan.reconstruction, context.sub(0.2));
  return file->add(turnedField(field, refinement_->finest(), plan.turn), gridSpec(plan), context);
}

/// A flux is baked from its vector potential: by commutation the refined potential's derivative is
/// the refined form.
VdbGridInfo FormBaker::addCirculations(const BakePlan& plan, const ControlForm& control,
                                       VdbFile* file, const Context& context) const {
  const auto& potential = std::get<Cochain<1>>(control.potential);
  const Array<Vec3> vectors =
      plan.turn(refinement_->limitVectors(control.as<2>(), plan.mode, context.sub(0.1)));
  const bool walls = plan.mode == BoundaryMode::Walls && plan.boundaryRule.empty();
  PotentialField field(refinement_->finest(),
                       plan.turn(refinement_->positions(plan.resolution.levels)),
                       refinement_->refine(potential, plan.mode, context.sub(0.1)), vectors, walls);
  if (plan.sampling == Sampling::Staggered) {
    return file->add(field, gridSpec(plan), context);
  }
  const VectorField samples(std::make_shared<VertexField<3>>(
      refinement_->finest(), plan.turn(refinement_->limitPositions()), vectors));
  const MeanFluxField means{samples, std::move(field), plan.neighbours};
  return file->add(means, gridSpec(plan), context);
}

/// A gradient is baked as differences of its potential.
VdbGridInfo FormBaker::addDifferences(const BakePlan& plan, const ControlForm& control,
                                      VdbFile* file, const Context& context) const {
  const auto& potential = std::get<Cochain<0>>(control.potential);
  const auto finest = refinement_->finest();
  const GradientField field =
      makeGradientField(finest, refinement_->limitPositions(),
                        refinement_->limitValues(potential, plan.mode, context.sub(0.1)),
                        refinement_->limitVectors(control.as<1>(), plan.mode, context.sub(0.1)));
  const GradientField turned{turnedField(field.base, finest, plan.turn),
                             turnedField(field.vectors, finest, plan.turn)};
  return file->add(turned, gridSpec(plan), context);
}

VdbGridSpec FormBaker::gridSpec(const BakePlan& plan) const {
  using Class = VdbGridSpec::Class;
  VdbGridSpec spec;
  spec.name = plan.grid;
  spec.reasons = plan.reasons;
  spec.frame.voxelSize = plan.resolution.voxelSize;
  spec.part = plan.part;
  if (plan.part) spec.frame.window = plan.part->window;
  spec.shift = plan.shift;
  spec.half = options_.half;
  spec.sampling = plan.sampling;
  if (plan.degree == 1) spec.vectorType = VdbGridSpec::VectorType::Covariant;
  if (plan.sampling == Sampling::Staggered) spec.gridClass = Class::Staggered;
  if (plan.degree == 3 || target_.fogClass) spec.gridClass = Class::Fog;
  const bool limit = plan.reconstruction == Reconstruction::Limit;
  spec.metadata = {{"octet_form", plan.form},
                   {"octet_degree", static_cast<std::int32_t>(plan.degree)},
                   {"octet_derivative", static_cast<std::int32_t>(options_.derivative)},
                   {"octet_unit", plan.unit},
                   {"octet_levels", static_cast<std::int32_t>(plan.resolution.levels)},
                   {"octet_boundary", boundaryWord(plan.boundaryRule, plan.mode)},
                   {"octet_wall_surface", std::string(wallSurfaceWord(options_.wallSurface))},
                   {"octet_reconstruction", std::string(limit ? "limit" : "whitney")}};
  return spec;
}

}  // namespace octet
