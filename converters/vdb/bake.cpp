// SPDX-License-Identifier: Apache-2.0
#include "bake.h"

#include <cstdio>
#include <filesystem>

#include "form_baker.h"
#include "form_choice.h"

namespace octet {
namespace {

/// name.vdb, 7 -> name.0007.vdb
std::string numbered(const std::string& path, int frame) {
  char number[16];
  std::snprintf(number, sizeof number, ".%04d", frame);
  const std::filesystem::path p(path);
  return (p.parent_path() / (p.stem().string() + number + p.extension().string())).string();
}

BakedFile bakeFile(const ControlAsset& asset, const FormChoice& choice, const FormBaker& baker,
                   const std::string& path, std::optional<int> frame,
                   const ProgressCallback& progress) {
  BakedFile file{path, frame, {}};
  VdbFile vdb;
  for (const Form* form : choice.forms()) {
    file.grids.push_back(baker.bake(*form, choice.gridName(*form), frame, &vdb));
  }
  std::vector<VdbMetadata> metadata = {{"octet_asset", asset.name},
                                       {"octet_up_axis", std::string(1, baker.upAxis())},
                                       {"octet_meters_per_unit", asset.units.metersPerUnit},
                                       {"octet_frames_per_second", asset.units.framesPerSecond}};
  if (frame) metadata.push_back({"octet_frame", static_cast<std::int32_t>(*frame)});
  vdb.write(path, metadata, progress);
  return file;
}

}  // namespace

BakeReport bake(const ControlAsset& asset, const BakeOptions& options, const std::string& path) {
  const Target& target = findTarget(options.target);
  const FormChoice choice(asset, options, target);
  const GridChoice grid = chooseGrid(asset.mesh, options);
  const auto frames = choice.frames();
  const FormBaker baker(asset, options, target, grid);
  BakeReport report;
  report.levels = grid.levels;
  report.cells = baker.finest().cellCount();
  report.voxelSize = grid.voxelSize;
  report.meanEdge = baker.finestEdge();
  report.note = target.note;

  const auto bakeTo = [&](const std::string& to, std::optional<int> frame) {
    report.files.push_back(bakeFile(asset, choice, baker, to, frame, options.progress));
  };
  if (!frames) {
    bakeTo(path, std::nullopt);
    return report;
  }
  for (int frame = frames->first; frame <= frames->second; ++frame) {
    bakeTo(numbered(path, frame), frame);
  }
  return report;
}

}  // namespace octet
