// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake_plan.h"

namespace octet {

/// The tiles of a grid that a bake is of; all unless options ask for a part.
/// @throws InputError for a region or a shard that there is none of
IndexBox bakeWindow(const BakeOptions& options, const MeshFacts& facts, double voxelSize);

/// What the grids of a bake are of the whole, when options ask for a part.
class BakePart {
 public:
  /// @throws InputError as bakeWindow()
  BakePart(const BakeOptions& options, const MeshFacts& facts, const ResolutionPlan& resolution);

  /// @param tag  of the whole (ContentTags): parts of one bake have the same
  std::optional<GridPart> at(const std::string& tag) const;
  /// partName(), empty for the whole.
  std::string name() const { return part_ ? partName(*part_) : ""; }

 private:
  std::optional<GridPart> part_;  // without its tag
};

}  // namespace octet
