// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../control_asset/control_asset.h"
#include "bake_plan.h"

namespace octet {

/// Name of the tag among a file's metadata.
inline constexpr const char* kContentMetadata = "octet_content";

/// A form of a bake, as it is going to be baked.
struct TaggedForm {
  const Form* form = nullptr;
  std::string grid;
  BoundaryMode mode = BoundaryMode::Walls;
};

/// @brief Tells what the files of a bake are made from: the mesh, the forms' coefficients at a
/// frame, units, all options that change a byte, and the version of this library. Files of the same
/// tag hold the same bytes, so that whoever finds one need not bake it again. What only chooses
/// among files (frames, parts of a whole) is not in it.
///
/// A tag is a UUID of version 5: SHA-1 of all that.
class ContentTags {
 public:
  /// @param plan  how fine it is: one size has one tag, whether asked for by voxels or resolution.
  /// The asset must outlive it.
  ContentTags(const ControlAsset& asset, const BakeOptions& options, const ResolutionPlan& plan,
              std::vector<TaggedForm> forms);

  std::string of(std::optional<int> frame) const;

 private:
  const ControlAsset& asset_;
  std::vector<TaggedForm> forms_;
  std::string common_;  // tag of what all frames share
};

}  // namespace octet
