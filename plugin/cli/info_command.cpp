// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/converters/vdb/vdb_file.h>
#include <octet/core/forms/coboundary.h>

#include "commands.h"
#include "console.h"
#include "mesh_report.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string path;
  bool json = false;
};

/// Largest |d w| and |w| over the frames of a form, and how many coefficients are not 0.
template <int K>
Json describeForm(const ControlAsset& asset, const Form& form) {
  const Complex& complex = *asset.mesh.complex();
  double derivative = 0, size = 0;
  std::size_t nonzero = 0;
  std::vector<int> frames = {0};
  if (form.animated()) frames.clear();
  for (const auto& [frame, values] : form.frames) frames.push_back(frame);
  for (const int frame : frames) {
    const Cochain<K> w = coefficients<K>(asset, form, frame);
    size = std::max(size, maxNorm(w.values()));
    std::size_t n = 0;
    for (const double x : w.values()) n += x != 0;
    nonzero = std::max(nonzero, n);
    if constexpr (K < 3) derivative = std::max(derivative, maxNorm(d(complex, w).values()));
  }
  Json result = {{"name", form.name}, {"degree", K}, {"unit", form.unit}};
  if (form.animated()) {
    result["frames"] = {form.frames.begin()->first, form.frames.rbegin()->first};
  }
  result["coefficients"] = complex.count(K);
  result["nonzero"] = nonzero;
  result["max"] = size;
  if (K < 3) result["max_derivative"] = derivative;
  const BoundaryMode mode = boundaryMode(asset, form, BoundaryChoice{});
  result["boundary"] = mode == BoundaryMode::Walls ? "walls" : "open";
  return result;
}

Json describeAsset(const std::string& path) {
  const ControlAsset asset = readAsset(path);
  Json result = {{"kind", "control asset"},
                 {"name", asset.name},
                 {"up_axis", std::string(1, asset.units.upAxis)},
                 {"meters_per_unit", asset.units.metersPerUnit},
                 {"frames_per_second", asset.units.framesPerSecond}};
  result.update(describeMesh(asset.mesh));
  result["forms"] = Json::array();
  for (const Form& form : asset.forms) {
    result["forms"].push_back(form.degree == 0   ? describeForm<0>(asset, form)
                              : form.degree == 1 ? describeForm<1>(asset, form)
                              : form.degree == 2 ? describeForm<2>(asset, form)
                                                 : describeForm<3>(asset, form));
  }
  return result;
}

Json toJson(const std::vector<VdbMetadata>& metadata) {
  Json result = Json::object();
  for (const VdbMetadata& m : metadata) {
    std::visit([&](const auto& value) { result[m.name] = value; }, m.value);
  }
  return result;
}

Json describeVdb(const std::string& path) {
  std::vector<VdbMetadata> fileMetadata;
  const auto grids = readVdbInfo(path, &fileMetadata, consoleContext());
  Json result = {{"kind", "OpenVDB file"}, {"metadata", toJson(fileMetadata)}};
  result["grids"] = Json::array();
  for (const VdbGridInfo& grid : grids) {
    result["grids"].push_back({{"name", grid.name},
                               {"type", grid.type},
                               {"class", grid.gridClass},
                               {"vector_type", grid.vectorType},
                               {"half", grid.half},
                               {"voxel_size", grid.voxelSize},
                               {"active_voxels", grid.activeVoxels},
                               {"leaves", grid.leaves},
                               {"index_min", grid.indexMin},
                               {"index_max", grid.indexMax},
                               {"min", grid.min},
                               {"max", grid.max},
                               {"metadata", toJson(grid.metadata)}});
  }
  return result;
}

void run(const Arguments& arguments) {
  const bool vdb = std::filesystem::path(arguments.path).extension() == ".vdb";
  const Json document = vdb ? describeVdb(arguments.path) : describeAsset(arguments.path);
  if (arguments.json) {
    std::cout << text(document) << "\n";
  } else {
    printPlain(document);
  }
}

}  // namespace

void addInfo(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      program->add_subcommand("info", "Describe a control asset, a mesh or a .vdb file");
  command->add_option("FILE", arguments->path, "Control asset, mesh or .vdb")->required();
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
