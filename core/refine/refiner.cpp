// SPDX-License-Identifier: Apache-2.0
#include "refiner.h"

#include <cmath>

#include "../base/parallel.h"
#include "../forms/coboundary.h"
#include "../topology/split.h"
#include "cell_memory.h"
#include "most_levels.h"
#include "step_adjoint.h"

namespace octet {
namespace {
/// Reports the building of a level, part by part; what is done is told in cells.
class LevelProgress {
 public:
  LevelProgress(const Context& context, int level, std::int64_t cells)
      : context_(context),
        stage_("build level " + std::to_string(level)),
        cells_(static_cast<std::size_t>(cells)) {
    report(0);
  }
  /// Rough shares of the time, when each part ends.
  enum Percent { kTopology = 25, kSmoothing = 35, kPositions = 50, kAll = 100 };
  void report(int percent) const {
    context_.report({stage_, cells_ * static_cast<std::size_t>(percent) / kAll, cells_, "cells"});
  }

 private:
  const Context context_;
  std::string stage_;
  std::size_t cells_;
};

/// The part of the work on all levels that level k is: each has eight times the cells of the last.
double shareOfLevel(int k, int levels) {
  return std::pow(8.0, k) * 7 / (std::pow(8.0, levels + 1) - 8);
}
}  // namespace

/// A level with the operators that lead to it from the one before.
struct Refiner::Level {
  std::shared_ptr<const Complex> complex;
  Array<Vec3> positions;
  Boundary boundary;
  LatticeSites sites;
  std::unique_ptr<Smoothing> smoothing;
  std::unique_ptr<PatchTest> patchTest;
};

Refiner::Refiner(const ControlMesh& mesh, const RefinerOptions& options, const Context& context)
    : options_(options),
      linear_(options.zeta),
      kernels_(std::make_unique<CellKernels>(options.zeta)),
      scratch_(std::make_unique<ScratchPool>()) {
  if (options.levels < 0 || options.levels > kMostLevels) {
    throw InputError("levels", std::to_string(options.levels) + " is not between 0 and " +
                                   std::to_string(kMostLevels));
  }
  if (!std::isfinite(options.zeta)) throw InputError("zeta", "is not a finite number");
  if (options.patchTest && options.boundaryRows == BoundaryRows::Star) {
    throw InputError("boundary rows", "the patch test needs those of the surface");
  }
  auto control = std::make_unique<Level>();
  control->complex = mesh.complex();
  control->positions = mesh.positions();
  control->boundary = Boundary(*control->complex, mesh.corners(), nullptr);
  if (options.levels == 0) control->sites = LatticeSites(*control->complex);
  levels_.push_back(std::move(control));
  double reserved = 0;
  for (int k = 1; k <= options.levels; ++k) {
    const Level& coarse = *levels_.back();
    reserved += kOperatorBytesPerCell * static_cast<double>(coarse.complex->children().cellCount());
    memory_ = MemoryReservation();
    memory_ = context.reserve(reserved, "the cells of " + std::to_string(k) + " levels");
    const LevelProgress progress(context.sub(shareOfLevel(k, options.levels)), k,
                                 coarse.complex->children().cellCount());
    auto fine = std::make_unique<Level>();
    fine->complex = split(coarse.complex);
    fine->boundary = Boundary(*fine->complex, mesh.corners(), &coarse.boundary);
    fine->sites = LatticeSites(*fine->complex);
    progress.report(LevelProgress::kTopology);
    fine->positions.resize(fine->complex->vertexCount());
    if (options.smooth) {
      fine->smoothing =
          std::make_unique<Smoothing>(*fine->complex, fine->boundary, coarse.boundary, fine->sites,
                                      *kernels_, scratch_.get(), options.boundaryRows);
    }
    progress.report(LevelProgress::kSmoothing);
    Array<double> before(coarse.complex->vertexCount()), linear(fine->complex->vertexCount()),
        after(fine->complex->vertexCount());
    for (int axis = 0; axis < 3; ++axis) {
      context.poll();
      parallelFor<Index>(coarse.complex->vertexCount(),
                         [&](Index v) { before[v] = coarse.positions[v][axis]; });
      linear_.apply0(*coarse.complex, before.data(), linear.data());
      if (options.smooth) fine->smoothing->apply0(before.data(), linear.data(), after.data());
      const Array<double>& result = options.smooth ? after : linear;
      parallelFor<Index>(fine->complex->vertexCount(),
                         [&](Index v) { fine->positions[v][axis] = result[v]; });
    }
    if (options.smooth) fine->smoothing->move(k, coarse.positions, &fine->positions);
    progress.report(LevelProgress::kPositions);
    if (options.smooth && options.patchTest) {
      Array<double> edges(fine->complex->edgeCount());
      const auto uncorrected = [&](const double* in, double* out) {
        linear_.apply1(*coarse.complex, in, edges.data());
        fine->smoothing->apply1(in, edges.data(), {}, out);
      };
      fine->patchTest =
          std::make_unique<PatchTest>(*fine->complex, fine->boundary, *kernels_, uncorrected,
                                      scratch_.get(), coarse.positions, fine->positions);
    }
    levels_.push_back(std::move(fine));
    progress.report(LevelProgress::kAll);
  }
}

Refiner::~Refiner() = default;
Refiner::Refiner(Refiner&&) noexcept = default;
Refiner& Refiner::operator=(Refiner&&) noexcept = default;

int Refiner::levels() const { return static_cast<int>(levels_.size()) - 1; }
const Complex& Refiner::complex(int level) const { return *levels_.at(level)->complex; }
std::shared_ptr<const Complex> Refiner::sharedComplex(int level) const {
  return levels_.at(level)->complex;
}
const Array<Vec3>& Refiner::positions(int level) const { return levels_.at(level)->positions; }
const Boundary& Refiner::boundary(int level) const { return levels_.at(level)->boundary; }
const LatticeSites& Refiner::sites(int level) const { return levels_.at(level)->sites; }

template <int K>
Cochain<K> Refiner::step(int level, const Cochain<K>& form, BoundaryMode mode,
                         const Context& context) const {
  const Complex& coarse = complex(level);
  const Complex& fine = complex(level + 1);
  const Level& to = *levels_.at(level + 1);
  form.checkOn(coarse);
  context.poll();
  Cochain<K> result(fine);
  auto loan = scratch_->take(to.smoothing ? result.size() : 0);
  double* const linear = to.smoothing ? loan.data() : result.data();
  const Correction correction{to.patchTest.get(), mode};
  if constexpr (K == 0) {
    linear_.apply0(coarse, form.data(), linear);
    context.poll();
    if (to.smoothing) to.smoothing->apply0(form.data(), linear, result.data());
  } else if constexpr (K == 1) {
    linear_.apply1(coarse, form.data(), linear);
    context.poll();
    if (to.smoothing) to.smoothing->apply1(form.data(), linear, correction, result.data());
  } else if constexpr (K == 2) {
    linear_.apply2(coarse, form.data(), linear);
    context.poll();
    if (to.smoothing) to.smoothing->apply2(form.data(), linear, correction, result.data());
  } else {
    linear_.apply3(coarse, form.data(), linear);
    context.poll();
    if (to.smoothing) to.smoothing->apply3(form.data(), linear, result.data());
  }
  return result;
}

StepAdjoint Refiner::rows(int level, BoundaryMode mode) const {
  if (options_.boundaryRows == BoundaryRows::Star) {
    throw InputError("boundary rows", "influences are known for those of the surface only");
  }
  const Level& to = *levels_.at(level + 1);
  return {*to.complex, to.sites, kernels_->linear, to.smoothing.get(), {to.patchTest.get(), mode}};
}

template <int K>
Cochain<K> Refiner::refine(Cochain<K> form, BoundaryMode mode, const Context& context) const {
  for (int level = 0; level < levels(); ++level) {
    const auto total = static_cast<std::size_t>(complex(level + 1).count(K));
    const std::string stage = "refine to level " + std::to_string(level + 1);
    const Context part = context.sub(shareOfLevel(level + 1, levels()));
    part.report({stage, 0, total, "coefficients"});
    form = step(level, form, mode, part);
    part.report({stage, total, total, "coefficients"});
  }
  return form;
}

template <int K>
BoundaryMode automaticMode(const Complex& control, const Cochain<K>& form) {
  form.checkOn(control);
  for (Index k = 0; k < form.size(); ++k) {
    if (form[k] == 0) continue;
    if (K == 1 && control.edgeOnBoundary(k)) return BoundaryMode::Open;
    if (K == 2 && control.facetOnBoundary(k)) return BoundaryMode::Open;
  }
  return BoundaryMode::Walls;
}

template Cochain<0> Refiner::step(int, const Cochain<0>&, BoundaryMode, const Context&) const;
template Cochain<1> Refiner::step(int, const Cochain<1>&, BoundaryMode, const Context&) const;
template Cochain<2> Refiner::step(int, const Cochain<2>&, BoundaryMode, const Context&) const;
template Cochain<3> Refiner::step(int, const Cochain<3>&, BoundaryMode, const Context&) const;
template Cochain<0> Refiner::refine(Cochain<0>, BoundaryMode, const Context&) const;
template Cochain<1> Refiner::refine(Cochain<1>, BoundaryMode, const Context&) const;
template Cochain<2> Refiner::refine(Cochain<2>, BoundaryMode, const Context&) const;
template Cochain<3> Refiner::refine(Cochain<3>, BoundaryMode, const Context&) const;
template BoundaryMode automaticMode(const Complex&, const Cochain<0>&);
template BoundaryMode automaticMode(const Complex&, const Cochain<1>&);
template BoundaryMode automaticMode(const Complex&, const Cochain<2>&);
template BoundaryMode automaticMode(const Complex&, const Cochain<3>&);

}  // namespace octet
