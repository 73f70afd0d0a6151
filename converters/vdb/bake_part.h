// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../control_asset/control_asset.h"
#include "../io/content_hash.h"
#include "bake_plan.h"

namespace octet {

/// The tiles of a grid that a bake is of; all unless options ask for a part.
/// @throws InputError for a region or a shard that there is none of
IndexBox bakeWindow(const BakeOptions& options, const MeshFacts& facts, double voxelSize);

/// @brief What the grids of a bake are of the whole, when options ask for a part. The tag is made
/// from all that the whole depends on: the asset's content, the options, the resolution and levels
/// that follow from them, the frame, the library's version.
class BakePart {
 public:
  /// @throws InputError as bakeWindow()
  BakePart(const ControlAsset& asset, const BakeOptions& options, const MeshFacts& facts,
           const ResolutionPlan& resolution);

  /// @param frame  none for a constant asset
  std::optional<GridPart> at(std::optional<int> frame) const;

 private:
  std::optional<GridPart> part_;  // without its tag
  ContentHash hash_;              // of everything but the frame
};

}  // namespace octet
