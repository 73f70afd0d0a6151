// SPDX-License-Identifier: Apache-2.0
#include "bake.h"

#include <algorithm>
#include <cmath>

#include <octet/core/base/memory_budget.h>

#include "../io/frames.h"
#include "bake_part.h"
#include "content_tag.h"
#include "form_baker.h"
#include "form_choice.h"
#include "vdb_head.h"

namespace octet {
namespace {

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
  if (!frames) return {{outputAt(path, std::nullopt), std::nullopt}};
  const FrameName name = FrameName(path).numbered();
  std::vector<std::pair<std::string, std::optional<int>>> files;
  for (const int frame : *frames) files.emplace_back(name.at(frame), frame);
  return files;
}

/// Tags for the files of a bake.
ContentTags tagsOf(const ControlAsset& asset, const BakeOptions& options,
                   const ResolutionPlan& resolution, const FormChoice& choice,
                   const ControlForms& forms) {
  std::vector<TaggedForm> tagged;
  for (const Form* form : choice.forms()) {
    tagged.push_back({form, choice.gridName(*form), forms.mode(*form)});
  }
  return ContentTags(asset, options, resolution, std::move(tagged));
}

/// Is a complete file there that was made from the same, and is the same part of it?
/// @param part  empty: the whole
bool isThere(const std::string& path, const std::string& tag, const std::string& part) {
  const auto metadata = readVdbHead(path);
  if (!metadata) return false;
  const auto textOf = [&](const std::string& name) -> std::string {
    for (const VdbMetadata& m : *metadata) {
      if (m.name == name) return std::get<std::string>(m.value);
    }
    return "";
  };
  return textOf(kContentMetadata) == tag && textOf(kPartMetadata) == part;
}

/// Plans grids of one asset, form by form.
class Planner {
 public:
  Planner(const ControlForms& forms, const BakeOptions& options, const BakeFacts& facts)
      : forms_(forms), options_(options), facts_(facts) {
    checkMethod(options, facts.refinement);
  }

  ControlForm find(const Form& form, const std::string& grid, std::optional<int> frame,
                   const Context& context) const {
    return forms_.find(form, grid, frame, facts_, context);
  }
  BakePlan plan(const ControlForm& form) const { return planBake(form.facts, options_, facts_); }

 private:
  const ControlForms& forms_;
  const BakeOptions& options_;
  const BakeFacts& facts_;
};

std::vector<VdbMetadata> fileMetadata(const ControlAsset& asset, const Target& target,
                                      std::optional<int> frame, const std::string& tag,
                                      const std::string& part) {
  const char upAxis = target.upAxis ? target.upAxis : asset.units.upAxis;
  std::vector<VdbMetadata> metadata = {{"octet_asset", asset.name},
                                       {"octet_up_axis", std::string(1, upAxis)},
                                       {"octet_meters_per_unit", asset.units.metersPerUnit},
                                       {"octet_frames_per_second", asset.units.framesPerSecond}};
  if (frame) metadata.push_back({kFrameMetadata, static_cast<std::int32_t>(*frame)});
  metadata.push_back({kContentMetadata, tag});
  if (!part.empty()) metadata.push_back({kPartMetadata, part});
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
  const BakePart part(options, mesh, resolution);
  const ControlForms forms(asset, options);
  const ContentTags tags = tagsOf(asset, options, resolution, choice, forms);
  BakeReport report;
  report.levels = resolution.levels;
  report.cells = std::llround(resolution.cells);
  report.voxelSize = resolution.voxelSize;
  report.meanEdge = resolution.fineEdge;
  report.note = target.note;
  report.part = part.name();
  std::size_t left = 0;
  for (const auto& [to, frame] : filesOf(choice, path)) {
    const bool skip = options.skipExisting && isThere(to, tags.of(frame), part.name());
    report.files.push_back({to, frame, {}, skip});
    left += skip ? 0 : 1;
  }
  if (left == 0) return report;
  checkMemory(resolution, options, mesh, memoryLimit());
  const MemoryReservation grids = context.reserve(resolution.gridBytes, "the grids of a file");
  const FormBaker baker(asset.mesh, options, resolution.levels, context.sub(0.3));
  const BakeFacts facts{asset.units.upAxis, resolution, baker.facts()};
  const Planner planner(forms, options, facts);
  report.cells = baker.finest().cellCount();
  report.meanEdge = facts.refinement.fineEdge;
  const Context rest = context.sub(0.7);
  for (BakedFile& file : report.files) {
    if (file.skipped) continue;
    const Context ofFile = rest.sub(1.0 / static_cast<double>(left));
    const double share = 0.9 / static_cast<double>(std::max<std::size_t>(1, choice.forms().size()));
    const std::string tag = tags.of(file.frame);
    VdbFile vdb;
    for (const Form* form : choice.forms()) {
      const Context ofForm = ofFile.sub(share);
      const ControlForm control =
          planner.find(*form, choice.gridName(*form), file.frame, ofForm.sub(0.1));
      BakePlan plan = planner.plan(control);
      plan.part = part.at(tag);
      file.grids.push_back(baker.execute(plan, control, &vdb, ofForm));
    }
    vdb.write(file.path, fileMetadata(asset, target, file.frame, tag, part.name()), ofFile);
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
  const BakePart part(options, mesh, forecast.resolution);
  forecast.memory = memoryLimit();
  forecast.note = target.note;
  RefinerOptions unrefined;
  unrefined.levels = 0;
  unrefined.boundaryRows = options.wallSurface;
  const auto unrefinedMesh = options.boundary.subdivide(asset.mesh, unrefined, context);
  const BakeFacts facts{asset.units.upAxis, forecast.resolution,
                        describe(*unrefinedMesh, forecast.resolution.fineEdge)};
  const ControlForms forms(asset, options);
  const Planner planner(forms, options, facts);
  const ContentTags tags = tagsOf(asset, options, forecast.resolution, choice, forms);
  for (const auto& [to, frame] : filesOf(choice, path)) {
    PlannedFile file{
        to, frame, {}, options.skipExisting && isThere(to, tags.of(frame), part.name())};
    for (const Form* form : choice.forms()) {
      file.grids.push_back(
          planner.plan(planner.find(*form, choice.gridName(*form), frame, context)));
      file.grids.back().part = part.at(tags.of(frame));
    }
    forecast.files.push_back(std::move(file));
  }
  return forecast;
}

}  // namespace octet
