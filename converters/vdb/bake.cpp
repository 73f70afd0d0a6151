// SPDX-License-Identifier: Apache-2.0
#include "bake.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <octet/core/base/memory_budget.h>

#include "bake_part.h"
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

/// What is known of the mesh, and what grids are made on it.
MeshFacts factsOf(const ControlAsset& asset, const FormChoice& choice, const BakeOptions& options,
                  const Context& context) {
  MeshFacts facts = findMeshFacts(asset, options, context);
  for (const Form* form : choice.forms()) {
    const int degree = choice.bakedDegree(*form);
    ++(degree == 1 || degree == 2 ? facts.vectors : facts.scalars);
  }
  return facts;
}

/// The files of a bake and their frames, in order.
std::vector<std::pair<std::string, std::optional<int>>> filesOf(const FormChoice& choice,
                                                                const std::string& path) {
  const auto frames = choice.frames();
  if (!frames) return {{path, std::nullopt}};
  std::vector<std::pair<std::string, std::optional<int>>> files;
  for (int frame = frames->first; frame <= frames->second; ++frame) {
    files.emplace_back(numbered(path, frame), frame);
  }
  return files;
}

/// Plans grids of one asset, form by form.
class Planner {
 public:
  Planner(const ControlAsset& asset, const BakeOptions& options, const BakeFacts& facts)
      : options_(options), facts_(facts), forms_(asset, options) {
    checkMethod(options, facts.refinement);
  }

  ControlForm find(const Form& form, const std::string& grid, std::optional<int> frame,
                   const Context& context) const {
    return forms_.find(form, grid, frame, facts_, context);
  }
  BakePlan plan(const ControlForm& form) const { return planBake(form.facts, options_, facts_); }

 private:
  const BakeOptions& options_;
  const BakeFacts& facts_;
  ControlForms forms_;
};

std::vector<VdbMetadata> fileMetadata(const ControlAsset& asset, const Target& target,
                                      std::optional<int> frame) {
  const char upAxis = target.upAxis ? target.upAxis : asset.units.upAxis;
  std::vector<VdbMetadata> metadata = {{"octet_asset", asset.name},
                                       {"octet_up_axis", std::string(1, upAxis)},
                                       {"octet_meters_per_unit", asset.units.metersPerUnit},
                                       {"octet_frames_per_second", asset.units.framesPerSecond}};
  if (frame) metadata.push_back({kFrameMetadata, static_cast<std::int32_t>(*frame)});
  return metadata;
}

}  // namespace

BakeReport bake(const ControlAsset& asset, const BakeOptions& options, const std::string& path,
                const Context& context) {
  checkVdbName(path);
  const Target& target = findTarget(options.target);
  const FormChoice choice(asset, options, target);
  const MeshFacts mesh = factsOf(asset, choice, options, context);
  const auto resolution = planResolution(options, mesh);
  const BakePart part(asset, options, mesh, resolution);
  checkMemory(resolution, options, mesh, memoryLimit());
  const MemoryReservation grids = context.reserve(resolution.gridBytes, "the grids of a file");
  const auto files = filesOf(choice, path);
  const FormBaker baker(asset.mesh, options, resolution.levels, context.sub(0.3));
  const BakeFacts facts{asset.units.upAxis, resolution, baker.facts()};
  const Planner planner(asset, options, facts);
  BakeReport report;
  report.levels = resolution.levels;
  report.cells = baker.finest().cellCount();
  report.voxelSize = resolution.voxelSize;
  report.meanEdge = facts.refinement.fineEdge;
  report.note = target.note;
  if (const auto first = part.at(std::nullopt)) report.part = partName(*first);
  const Context rest = context.sub(0.7);
  for (const auto& [to, frame] : files) {
    const Context ofFile = rest.sub(1.0 / static_cast<double>(files.size()));
    const double share = 0.9 / static_cast<double>(std::max<std::size_t>(1, choice.forms().size()));
    BakedFile file{to, frame, {}};
    VdbFile vdb;
    for (const Form* form : choice.forms()) {
      const Context ofForm = ofFile.sub(share);
      const ControlForm control =
          planner.find(*form, choice.gridName(*form), frame, ofForm.sub(0.1));
      BakePlan plan = planner.plan(control);
      plan.part = part.at(frame);
      file.grids.push_back(baker.execute(plan, control, &vdb, ofForm));
    }
    vdb.write(to, fileMetadata(asset, target, frame), ofFile);
    report.files.push_back(std::move(file));
  }
  return report;
}

BakeForecast foreseeBake(const ControlAsset& asset, const BakeOptions& options,
                         const std::string& path, const Context& context) {
  checkVdbName(path);
  const Target& target = findTarget(options.target);
  const FormChoice choice(asset, options, target);
  BakeForecast forecast;
  const MeshFacts mesh = factsOf(asset, choice, options, context);
  forecast.resolution = planResolution(options, mesh);
  const BakePart part(asset, options, mesh, forecast.resolution);
  forecast.memory = memoryLimit();
  forecast.note = target.note;
  RefinerOptions unrefined;
  unrefined.levels = 0;
  unrefined.boundaryRows = options.wallSurface;
  const auto unrefinedMesh = options.boundary.subdivide(asset.mesh, unrefined, context);
  const BakeFacts facts{asset.units.upAxis, forecast.resolution,
                        describe(*unrefinedMesh, forecast.resolution.fineEdge)};
  const Planner planner(asset, options, facts);
  for (const auto& [to, frame] : filesOf(choice, path)) {
    PlannedFile file{to, frame, {}};
    for (const Form* form : choice.forms()) {
      file.grids.push_back(
          planner.plan(planner.find(*form, choice.gridName(*form), frame, context)));
      file.grids.back().part = part.at(frame);
    }
    forecast.files.push_back(std::move(file));
  }
  return forecast;
}

}  // namespace octet
