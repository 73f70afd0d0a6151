// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../control_asset/control_asset.h"
#include "bake_plan.h"
#include "vdb_file.h"

namespace octet {

/// One file of a bake.
struct BakedFile {
  std::string path;
  std::optional<int> frame;
  std::vector<VdbGridInfo> grids;  ///< none of a file that was there already
  bool skipped = false;            ///< it was, and is what would have been baked
};

/// What a bake did.
struct BakeReport {
  int levels = 0;
  std::int64_t cells = 0;  ///< at the finest level
  double voxelSize = 0, meanEdge = 0;
  std::string note;  ///< what the target's importer has to do
  std::string part;  ///< "shard 2 of 7", "region"; empty: the whole
  std::vector<BakedFile> files;
};

/// @brief The main job: control asset to OpenVDB. One grid per form (converters/README.md,
/// "Grids"); an animated asset becomes a numbered sequence, for which topology is refined once. The
/// frame's place in the files' names is as FrameName says (frames.h), before the ending by default.
/// @throws InputError, IoError, MemoryError, Cancelled; files finished before stay, the one in work
/// does not.
BakeReport bake(const ControlAsset& asset, const BakeOptions& options, const std::string& path,
                const Context& context = {});

/// What a bake would do: one file of it.
struct PlannedFile {
  std::string path;
  std::optional<int> frame;
  std::vector<BakePlan> grids;
  bool skipped = false;  ///< it is there, and a bake would leave it
};

/// What a bake would do.
struct BakeForecast {
  ResolutionPlan resolution;
  double memory = 0;  ///< of the machine, bytes
  std::string note;   ///< what the target's importer has to do
  std::vector<PlannedFile> files;
};

/// Plans a bake and writes nothing: potentials are looked for and forms projected, but the mesh is
/// refined just once, so that the size of cells is foreseen instead of measured.
/// @throws InputError as bake() does before it refines, but for memory: the forecast tells
BakeForecast foreseeBake(const ControlAsset& asset, const BakeOptions& options,
                         const std::string& path, const Context& context = {});

}  // namespace octet
