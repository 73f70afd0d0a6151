// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "../control_asset/control_asset.h"
#include "../control_asset/refined_document.h"
#include "targets.h"
#include "vdb_file.h"

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
  Sampling sampling = Sampling::Collocated;
  Reconstruction reconstruction = Reconstruction::Limit;
  std::string target = "openvdb";
  BakeMethod method = BakeMethod::Auto;
  bool half = false;
  bool project = false;  ///< replace 1- and 2-forms that are not closed by the nearest closed ones
  std::optional<std::pair<int, int>> frames;  ///< first and last; absent: all that the forms have
  double zeta = kDefaultZeta;
  ProgressCallback progress{};
};

/// One file of a bake.
struct BakedFile {
  std::string path;
  std::optional<int> frame;
  std::vector<VdbGridInfo> grids;
};

/// What a bake did.
struct BakeReport {
  int levels = 0;
  std::int64_t cells = 0;  ///< at the finest level
  double voxelSize = 0, meanEdge = 0;
  std::string note;  ///< what the target's importer has to do
  std::vector<BakedFile> files;
};

/// @brief The main job: control asset to OpenVDB. One grid per form (converters/README.md,
/// "Grids"); an animated asset becomes a numbered sequence `name.0001.vdb`, for which topology is
/// refined once.
/// @throws InputError, IoError, Cancelled; files finished before stay, the one in work does not.
BakeReport bake(const ControlAsset& asset, const BakeOptions& options, const std::string& path);

}  // namespace octet
