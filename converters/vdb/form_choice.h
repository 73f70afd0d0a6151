// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../control_asset/control_asset.h"
#include "bake_options.h"
#include "targets.h"

namespace octet {

/// @brief The forms that a bake is of, the names of their grids and the frames.
class FormChoice {
 public:
  /// The arguments must outlive it.
  /// @throws InputError when there is nothing to bake, a form is not there or has no derivative,
  /// or two grids would have the same name.
  FormChoice(const ControlAsset& asset, const BakeOptions& options, const Target& target);

  const std::vector<const Form*>& forms() const { return forms_; }
  /// Degree of what is baked of a form: its own, or its derivative's.
  int bakedDegree(const Form& form) const;
  /// The form's own name, or what the target looks for when it is the velocity.
  std::string gridName(const Form& form) const;

  /// Frames to bake; none when no form is animated.
  /// @throws InputError when frames are asked for that there are none of
  std::optional<std::vector<int>> frames() const;

 private:
  void takeAll();
  void takeNamed();
  void findVelocity();
  void checkNames() const;

  const ControlAsset& asset_;
  const BakeOptions& options_;
  const Target& target_;
  std::vector<const Form*> forms_;
  const Form* velocity_ = nullptr;
};

}  // namespace octet
