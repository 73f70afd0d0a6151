// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bake.h"
#include "grid_choice.h"
#include "turned_field.h"
#include "velocity_plan.h"

namespace octet {

/// @brief Bakes forms of one asset into grids, one by one: refines the mesh once, then per form and
/// frame refines coefficients, rebuilds the field and rasterises it.
class FormBaker {
 public:
  /// Refines the mesh. The arguments must outlive it, but for `grid`. @throws Cancelled
  FormBaker(const ControlAsset& asset, const BakeOptions& options, const Target& target,
            const GridChoice& grid);
  ~FormBaker();

  /// The finest level, its mean edge, and the up axis of the grids.
  const Complex& finest() const { return *refinement_->finest(); }
  double finestEdge() const;
  char upAxis() const { return turn_.to; }

  /// Adds the grid of a form, or of its derivative. @param frame  none for a constant asset
  /// @throws InputError, Cancelled
  VdbGridInfo bake(const Form& form, const std::string& gridName, std::optional<int> frame,
                   VdbFile* file) const;

 private:
  /// A grid in the making: of which form, under which name and boundary mode, to which file, and
  /// what there is to say about it.
  struct Job {
    const Form& form;
    const std::string& gridName;
    int frame;
    VdbFile* file;
    BoundaryMode mode = BoundaryMode::Walls;
    std::string note{};

    void say(const std::string& more);
  };

  template <int K>
  VdbGridInfo bakeForm(Job job) const;
  template <int K>
  VdbGridInfo bakeDerivative(Job job) const;
  template <int K>
  Cochain<K + 1> derivative(const Form& form, int frame) const;
  template <int K>
  BoundaryMode derivativeMode(const Form& form) const;

  VdbGridInfo addFlux(Job job, const Cochain<2>& control, const Cochain<1>* given) const;
  VdbGridInfo addCirculations(const Job& job, const Cochain<1>& potential,
                              const Cochain<2>& control) const;
  VdbGridInfo addGradient(Job job, const Cochain<1>& control, const Cochain<0>* given) const;
  template <int K>
  VdbGridInfo addSamples(const Job& job, const Cochain<K>& control) const;

  GradientField gradientField(const Cochain<0>& potential, const Cochain<1>& control,
                              BoundaryMode mode) const;
  void checkMethod() const;
  bool mayConserve() const;
  std::string whyMeansAreWorse() const;
  void refuseSamples(const Job& job) const;
  bool limitFields() const;
  /// What the boundary method does not keep, and what that means for a grid.
  std::string methodNote() const;
  template <int K>
  VdbGridSpec gridSpec(const Job& job) const;

  const ControlAsset& asset_;
  const BakeOptions& options_;
  const Target& target_;
  const GridChoice grid_;
  const AxisTurn turn_;
  VelocityPlanner planner_;
  std::unique_ptr<const Subdivision> refinement_;
  double voxelsPerEdge_ = 0;  // mean fine edge
};

}  // namespace octet
