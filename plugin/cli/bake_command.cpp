// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/vdb/bake.h>
#include <octet/core/base/error.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string control, output, levels = "auto", frames;
  bool json = false;
  BakeOptions options;
};

std::optional<int> parseLevels(const std::string& text) {
  if (text == "auto") return std::nullopt;
  std::size_t end = 0;
  int levels = -1;
  try {
    levels = std::stoi(text, &end);
  } catch (const std::exception&) {
  }
  if (end != text.size() || levels < 0 || levels > 12) {
    throw InputError("--levels", "\"" + text + "\" is neither auto nor a number from 0 to 12");
  }
  return levels;
}

/// "A-B" or "A".
std::optional<std::pair<int, int>> parseFrames(const std::string& text) {
  if (text.empty()) return std::nullopt;
  int first = 0, last = 0, end = 0;
  const int n = static_cast<int>(text.size());
  if (std::sscanf(text.c_str(), "%d-%d%n", &first, &last, &end) == 2 && end == n && first >= 0) {
    return std::pair{first, last};
  }
  if (std::sscanf(text.c_str(), "%d%n", &first, &end) == 1 && end == n && first >= 0) {
    return std::pair{first, first};
  }
  throw InputError("--frames", "\"" + text + "\" is neither a frame nor a range A-B");
}

nlohmann::ordered_json toJson(const VdbGridInfo& grid) {
  return {{"name", grid.name},
          {"type", grid.type},
          {"class", grid.gridClass},
          {"vector_type", grid.vectorType},
          {"voxel_size", grid.voxelSize},
          {"active_voxels", grid.activeVoxels},
          {"leaves", grid.leaves},
          {"index_min", grid.indexMin},
          {"index_max", grid.indexMax},
          {"min", grid.min},
          {"max", grid.max},
          {"half", grid.half}};
}

void print(const BakeReport& report, double seconds, bool json) {
  if (json) {
    nlohmann::ordered_json files = nlohmann::ordered_json::array();
    for (const BakedFile& file : report.files) {
      nlohmann::ordered_json entry = {{"path", file.path}};
      if (file.frame) entry["frame"] = *file.frame;
      entry["grids"] = nlohmann::ordered_json::array();
      for (const VdbGridInfo& grid : file.grids) entry["grids"].push_back(toJson(grid));
      files.push_back(std::move(entry));
    }
    const nlohmann::ordered_json document = {
        {"levels", report.levels},      {"cells", report.cells}, {"voxel_size", report.voxelSize},
        {"mean_edge", report.meanEdge}, {"seconds", seconds},    {"note", report.note},
        {"files", std::move(files)}};
    std::cout << document.dump(2) << "\n";
    return;
  }
  std::printf("%d levels, %s cells, mean edge %.4g, voxel %.4g\n", report.levels,
              grouped(report.cells).c_str(), report.meanEdge, report.voxelSize);
  for (const BakedFile& file : report.files) {
    std::printf("%s\n", file.path.c_str());
    for (const VdbGridInfo& grid : file.grids) {
      std::printf("  %s  %s%s, %s active voxels, %s %.4g to %.4g\n", grid.name.c_str(),
                  grid.type.c_str(), grid.half ? " (half)" : "",
                  grouped(static_cast<std::int64_t>(grid.activeVoxels)).c_str(),
                  grid.vectorType.empty() ? "value" : "length", grid.min, grid.max);
    }
  }
  if (!report.note.empty()) std::printf("note: %s\n", report.note.c_str());
  std::printf("%.2f s\n", seconds);
}

void run(Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  BakeOptions& options = arguments.options;
  options.levels = parseLevels(arguments.levels);
  options.frames = parseFrames(arguments.frames);
  options.progress = consoleProgress();
  const ControlAsset asset = readAsset(arguments.control);
  const BakeReport report = bake(asset, options, arguments.output);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print(report, seconds, arguments.json);
}

}  // namespace

void addBake(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  BakeOptions& options = arguments->options;
  CLI::App* command = program->add_subcommand(
      "bake", "Subdivide a control asset's forms and bake their limit fields into OpenVDB grids");
  command
      ->add_option("CONTROL", arguments->control, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command
      ->add_option("-o,--output", arguments->output, "The .vdb to write; name.####.vdb if animated")
      ->required();
  command->add_option("--form", options.forms, "Form to bake, by name; all by default");
  command->add_flag("--d", options.derivative,
                    "Bake the exterior derivative: the velocity of a vector potential");
  auto* size = command->add_option("--voxel-size", options.voxelSize, "Voxel size, world units");
  command->add_option("--resolution", options.resolution, "Voxels along the domain's longest side")
      ->excludes(size);
  command
      ->add_option("--levels", arguments->levels,
                   "Subdivisions; auto: until the mean edge is at most 2 voxels")
      ->capture_default_str();
  const std::map<std::string, BoundaryChoice> boundaries = {{"auto", BoundaryChoice::Auto},
                                                            {"walls", BoundaryChoice::Walls},
                                                            {"open", BoundaryChoice::Open}};
  command
      ->add_option("--boundary", options.boundary,
                   "walls: what is zero at the boundary stays zero; open: constants are exact "
                   "there; auto: walls for forms that are zero there")
      ->transform(CLI::CheckedTransformer(boundaries, CLI::ignore_case))
      ->option_text("auto|walls|open");
  const std::map<std::string, Sampling> samplings = {{"collocated", Sampling::Collocated},
                                                     {"staggered", Sampling::Staggered}};
  command->add_option("--grid", options.sampling, "Where a voxel's components are sampled")
      ->transform(CLI::CheckedTransformer(samplings, CLI::ignore_case))
      ->option_text("collocated|staggered");
  const std::map<std::string, Reconstruction> reconstructions = {
      {"limit", Reconstruction::Limit}, {"whitney", Reconstruction::Whitney}};
  command
      ->add_option("--reconstruction", options.reconstruction,
                   "limit: smooth, second order; whitney: Whitney forms on the finest level")
      ->transform(CLI::CheckedTransformer(reconstructions, CLI::ignore_case))
      ->option_text("limit|whitney");
  command->add_option("--target", options.target, "Conventions of the program that reads the grids")
      ->option_text("openvdb|blender|houdini|arnold|renderman");
  command->add_flag("--half", options.half, "Store 16-bit floats");
  command->add_option("--frames", arguments->frames, "Frames A-B of an animated asset");
  command->add_option("--zeta", options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
