// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/vdb/wording.h>
#include <octet/core/base/error.h>

#include "commands.h"
#include "console.h"
#include "file_text.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string control, output, levels = "auto";
  std::optional<std::string> frames, shard;
  std::vector<double> region;
  bool json = false, dryRun = false;
  BakeOptions options;
};

/// Digits only, and nothing after them.
std::optional<int> parseNumber(std::string_view text) {
  int number = 0;
  const char* const last = text.data() + text.size();
  const auto [end, status] = std::from_chars(text.data(), last, number);
  if (status != std::errc() || end != last || number < 0) return std::nullopt;
  return number;
}

std::optional<int> parseLevels(const std::string& text) {
  if (text == "auto") return std::nullopt;
  const auto levels = parseNumber(text);
  if (!levels || *levels > 12) {
    throw InputError("--levels", "\"" + text + "\" is neither auto nor a number from 0 to 12");
  }
  return levels;
}

/// "I/N".
Shard parseShard(const std::string& text) {
  const std::string_view view = text;
  const std::size_t slash = view.find('/');
  const auto number = parseNumber(view.substr(0, slash));
  const auto count = slash == view.npos ? std::nullopt : parseNumber(view.substr(slash + 1));
  if (!number || !count) throw InputError("--shard", "\"" + text + "\" is not I/N, as in 2/8");
  return {*number, *count};
}

Box parseRegion(const std::vector<double>& numbers) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = numbers[static_cast<std::size_t>(k)];
    box.max[k] = numbers[static_cast<std::size_t>(k) + 3];
  }
  return box;
}

std::string checkPositive(const std::string& text) {
  double x = 0;
  const bool positive = CLI::detail::lexical_cast(text, x) && x > 0 && std::isfinite(x);
  return positive ? "" : "\"" + text + "\" is not a positive number";
}

/// Does something with an asset. An error of it as a whole has no place, but it has a file.
template <typename Do>
auto withFile(const std::string& control, const Do& work) {
  try {
    return work();
  } catch (const InputError& e) {
    throw e.file().empty() && e.place().empty() ? e.inFile(control) : e;
  }
}

void print(const BakeReport& report, double seconds, bool json) {
  if (json) {
    nlohmann::ordered_json files = nlohmann::ordered_json::array();
    for (const BakedFile& file : report.files) files.push_back(cli::toJson(file));
    const nlohmann::ordered_json document = {{"levels", report.levels},
                                             {"cells", report.cells},
                                             {"voxel_size", report.voxelSize},
                                             {"mean_edge", report.meanEdge},
                                             {"seconds", seconds},
                                             {"note", report.note},
                                             {"part", report.part},
                                             {"files", std::move(files)}};
    std::cout << text(document) << "\n";
    return;
  }
  std::printf("%d levels, %s cells, mean edge %.4g, voxel %.4g\n", report.levels,
              grouped(report.cells).c_str(), report.meanEdge, report.voxelSize);
  if (!report.part.empty()) std::printf("%s\n", report.part.c_str());
  for (const BakedFile& file : report.files) cli::print(file);
  if (!report.note.empty()) std::printf("note: %s\n", report.note.c_str());
  std::printf("%.2f s\n", seconds);
}

const char* name(Sampling sampling) {
  return sampling == Sampling::Staggered ? "staggered" : "collocated";
}
const char* name(Reconstruction reconstruction) {
  return reconstruction == Reconstruction::Limit ? "limit" : "whitney";
}

nlohmann::ordered_json toJson(const BakePlan& plan) {
  nlohmann::ordered_json result = {{"name", plan.grid},
                                   {"form", plan.form},
                                   {"degree", plan.degree},
                                   {"boundary", boundaryWord(plan.boundaryRule, plan.mode)},
                                   {"reconstruction", name(plan.reconstruction)}};
  if (plan.method == GridMethod::None) return result;
  result["method"] = methodName(plan.method);
  result["grid"] = name(plan.sampling);
  result["reasons"] = nlohmann::ordered_json::array();
  for (const BakeReason& reason : plan.reasons) {
    result["reasons"].push_back({{"reason", reasonName(reason)}, {"note", words(reason)}});
  }
  return result;
}

void printJson(const BakeForecast& forecast) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const PlannedFile& file : forecast.files) {
    nlohmann::ordered_json entry = {{"path", file.path}};
    if (file.frame) entry["frame"] = *file.frame;
    if (file.skipped) entry["skipped"] = true;
    entry["grids"] = nlohmann::ordered_json::array();
    for (const BakePlan& plan : file.grids) entry["grids"].push_back(toJson(plan));
    files.push_back(std::move(entry));
  }
  const ResolutionPlan& r = forecast.resolution;
  std::cout << text({{"levels", r.levels},
                     {"cells", std::llround(r.cells)},
                     {"voxel_size", r.voxelSize},
                     {"mean_edge", r.fineEdge},
                     {"voxels", std::llround(r.voxels)},
                     {"bytes", std::llround(r.bytes())},
                     {"memory", std::llround(forecast.memory)},
                     {"note", forecast.note},
                     {"files", std::move(files)}})
            << "\n";
}

void print(const BakeForecast& forecast) {
  const ResolutionPlan& r = forecast.resolution;
  std::printf("%d levels, about %s cells, mean edge %.4g, voxel %.4g, about %s voxels\n", r.levels,
              grouped(std::llround(r.cells)).c_str(), r.fineEdge, r.voxelSize,
              grouped(std::llround(r.voxels)).c_str());
  std::printf("needs up to %.2g of %.2g GB of memory\n", r.bytes() / 1e9, forecast.memory / 1e9);
  for (const PlannedFile& file : forecast.files) {
    std::printf("%s%s\n", file.path.c_str(), file.skipped ? kSkipped : "");
    for (const BakePlan& plan : file.grids) {
      std::printf("  %s  from form %s, %s, %s boundary\n", plan.grid.c_str(), plan.form.c_str(),
                  name(plan.reconstruction), boundaryWord(plan.boundaryRule, plan.mode).c_str());
      if (plan.method == GridMethod::None) continue;
      std::printf("    %s from %s%s%s\n", name(plan.sampling), methodName(plan.method),
                  plan.reasons.empty() ? "" : "; ", words(plan.reasons).c_str());
    }
  }
  if (!forecast.note.empty()) std::printf("note: %s\n", forecast.note.c_str());
}

void foresee(const Arguments& arguments) {
  const ControlAsset asset = readAsset(arguments.control);
  const BakeForecast forecast = withFile(arguments.control, [&] {
    return foreseeBake(asset, arguments.options, arguments.output, consoleContext());
  });
  if (arguments.json) {
    printJson(forecast);
  } else {
    print(forecast);
  }
}

void run(Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  BakeOptions& options = arguments.options;
  options.levels = parseLevels(arguments.levels);
  if (arguments.frames) options.frames = readFrames(*arguments.frames);
  if (arguments.shard) options.shard = parseShard(*arguments.shard);
  if (!arguments.region.empty()) options.region = parseRegion(arguments.region);
  if (arguments.dryRun) return foresee(arguments);
  checkOutput(arguments.control, arguments.output);
  const ControlAsset asset = readAsset(arguments.control);
  const BakeReport report = withFile(
      arguments.control, [&] { return bake(asset, options, arguments.output, consoleContext()); });
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print(report, seconds, arguments.json);
}

}  // namespace

void addBoundary(CLI::App* command, BoundaryChoice* choice, bool methods) {
  std::string help =
      "walls: what is zero at the boundary stays zero; open: constants are exact there; auto: "
      "walls for forms that are zero there";
#ifdef OCTETVDB_WITH_THESIS
  if (methods) help += "; for comparison, the thesis' methods: simple, projection, expansion";
#endif
  addChoice(command, "--boundary", choice, boundaryChoices(methods), help);
}

void addWallSurface(CLI::App* command, BoundaryRows* rows) {
  addChoice(command, "--wall-surface", rows, wallSurfaceChoices(),
            "smooth: fairer, and flows stay bounded beside it; loop: exactly Loop's "
            "surface, as other programs subdivide the boundary");
}

void addBake(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  BakeOptions& options = arguments->options;
  CLI::App* command = program->add_subcommand(
      "bake", "Subdivide a control asset's forms and bake their limit fields into OpenVDB grids");
  command
      ->add_option("CONTROL", arguments->control, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command
      ->add_option(
          "-o,--output", arguments->output,
          "The .vdb to write; name.####.vdb if animated (or name.@@@@.vdb, %04d, $F4, <frame>)")
      ->required();
  command
      ->add_option("--form", options.forms,
                   "Form to bake, by name; may be repeated; all by default")
      ->allow_extra_args(false);  // else it takes CONTROL for a form
  command->add_flag("--d", options.derivative,
                    "Bake the exterior derivative: the velocity of a vector potential");
  auto* size = command->add_option("--voxel-size", options.voxelSize, "Voxel size, world units")
                   ->check(checkPositive);
  command->add_option("--resolution", options.resolution, "Voxels along the domain's longest side")
      ->check(checkPositive)
      ->excludes(size);
  command
      ->add_option("--levels", arguments->levels,
                   "Subdivisions; auto: until the mean edge is at most 2 voxels")
      ->capture_default_str();
  addBoundary(command, &options.boundary, true);
  addWallSurface(command, &options.wallSurface);
  addChoice(command, "--grid", &options.sampling, samplingChoices(),
            "Where a voxel's components are sampled");
  addChoice(command, "--reconstruction", &options.reconstruction, reconstructionChoices(),
            "limit: smooth, second order; whitney: Whitney forms on the finest level");
  addChoice(command, "--target", &options.target, targetChoices(),
            "Conventions of the program that reads the grids");
  addChoice(command, "--method", &options.method, methodChoices(),
            "conservative: vectors without discrete divergence (2-forms) or curl "
            "(1-forms), or an error; samples: of the field; auto: conservative where "
            "the form allows it and it costs no accuracy");
  command->add_flag("--half", options.half, "Store 16-bit floats");
  command->add_flag("--project", options.project,
                    "Replace 1- and 2-forms that are not closed by the nearest closed ones");
  command->add_option(
      "--frames", arguments->frames,
      "Frames of an animated asset, such as 1-10, 1-10x2 or 1,3,7-9; all by default");
  command->add_flag("--skip-existing", options.skipExisting,
                    "Leave files that are complete and from the same asset and options");
  auto* region = command
                     ->add_option("--region", arguments->region,
                                  "Bake only the leaves that this box meets, world units of the "
                                  "asset: x0 y0 z0 x1 y1 z1")
                     ->expected(6);
  command
      ->add_option("--shard", arguments->shard,
                   "Bake only part I of N, of about equal work: I/N, from 1/N to N/N; octetvdb "
                   "merge joins them")
      ->excludes(region);
  command->add_option("--zeta", options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_flag("--dry-run", arguments->dryRun,
                    "Say what would be baked and why so, and write nothing");
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
