// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake_plan.h"

namespace octet {

/// Refines an asset's mesh once to see what the levels after it will be like.
MeshFacts findMeshFacts(const ControlAsset& asset, const BakeOptions& bake,
                        const Context& context = {});

/// Tells what a subdivision can do. @param fineEdge  mean edge of the finest level
RefinementFacts describe(const Subdivision& subdivision, double fineEdge);

/// A form's coefficients on the control mesh at one frame, and a potential of theirs.
struct ControlForm {
  FormFacts facts;
  std::variant<Cochain<0>, Cochain<1>, Cochain<2>, Cochain<3>> form;  ///< by degree
  std::variant<std::monostate, Cochain<0>, Cochain<1>> potential;

  template <int K>
  const Cochain<K>& as() const {
    return std::get<Cochain<K>>(form);
  }
};

/// @brief Gives the forms of an asset as a bake needs them, on the control mesh: differentiated and
/// projected as options say, with their potentials where a plan seeks them. Factors are kept from
/// frame to frame.
class ControlForms {
 public:
  /// The arguments must outlive it.
  ControlForms(const ControlAsset& asset, const BakeOptions& options);

  /// @param frame  none for a constant asset. @throws InputError, Cancelled
  ControlForm find(const Form& form, const std::string& grid, std::optional<int> frame,
                   const BakeFacts& facts, const Context& context = {}) const;

  /// How what is baked of a form meets the boundary, in all frames alike.
  BoundaryMode mode(const Form& form) const;

 private:
  template <int K>
  Cochain<K + 1> derivative(const Form& form, int frame) const;
  template <int K>
  BoundaryMode derivativeMode(const Form& form) const;
  template <int K>
  void take(Cochain<K> control, const Cochain<K - 1>* given, const BakeFacts& facts,
            ControlForm* result, const Context& context) const;
  void findPotential(const Cochain<1>& control, const Cochain<0>* given, ControlForm* result,
                     const Context& context) const;
  void findPotential(const Cochain<2>& control, const Cochain<1>* given, ControlForm* result,
                     const Context& context) const;

  const ControlAsset& asset_;
  const BakeOptions& options_;
  VelocityPlanner planner_;
};

}  // namespace octet
