// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <octet/core/field/field.h>

#include "../control_asset/refined_document.h"
#include "grid_part.h"

namespace octet {

/// Where the values of vector grids come from (samples/conservation/README.md).
enum class BakeMethod : std::uint8_t {
  Auto,          ///< conservative where the form allows it and it costs no accuracy, else samples
  Conservative,  ///< circulations or differences of a potential, or an error
  Samples,       ///< samples of the field
};

/// What to bake of an asset, and how.
struct BakeOptions {
  std::vector<std::string> forms;  ///< names; empty: all
  bool derivative = false;         ///< bake the exterior derivative of the forms instead
  double voxelSize = 0;            ///< world units; or
  int resolution = 0;              ///< voxels along the domain's longest side
  std::optional<int> levels;       ///< subdivisions; absent: until the mean edge is <= 2 voxels
  BoundaryChoice boundary{};
  BoundaryRows wallSurface = BoundaryRows::Smooth;  ///< of the scheme's own rule
  Sampling sampling = Sampling::Collocated;
  Reconstruction reconstruction = Reconstruction::Limit;
  std::string target = "openvdb";
  BakeMethod method = BakeMethod::Auto;
  bool half = false;
  bool project = false;  ///< replace 1- and 2-forms that are not closed by the nearest closed ones
  std::optional<std::vector<int>> frames;  ///< absent: all that the forms have
  /// Leave files that are there, complete and made from the same (content_tag.h).
  bool skipExisting = false;
  double zeta = kDefaultZeta;
  std::optional<Box> region;   ///< bake only the leaves that it meets, world units of the asset
  std::optional<Shard> shard;  ///< bake only one of several parts
};

}  // namespace octet
