// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bake_facts.h"
#include "targets.h"
#include "vdb_file.h"

namespace octet {

/// @brief Carries plans out: refines the mesh once, then per plan refines coefficients, rebuilds
/// the field and rasterises it into a grid.
class FormBaker {
 public:
  /// Refines the mesh. The arguments must outlive it. @throws Cancelled
  FormBaker(const ControlMesh& mesh, const BakeOptions& options, int levels,
            const Context& context = {});

  const Complex& finest() const { return *refinement_->finest(); }
  /// What the refined mesh turned out to be.
  RefinementFacts facts() const;

  /// Adds a grid to a file. @throws InputError, Cancelled
  VdbGridInfo execute(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                      const Context& context = {}) const;

 private:
  template <int K>
  VdbGridInfo addSamples(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                         const Context& context) const;
  VdbGridInfo addCirculations(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                              const Context& context) const;
  VdbGridInfo addDifferences(const BakePlan& plan, const ControlForm& control, VdbFile* file,
                             const Context& context) const;
  VdbGridSpec gridSpec(const BakePlan& plan) const;

  const BakeOptions& options_;
  const Target& target_;
  std::unique_ptr<const Subdivision> refinement_;
};

}  // namespace octet
