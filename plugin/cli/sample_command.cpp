// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/vdb_sampling/sample_velocity.h>
#include <octet/core/base/error.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string cage, output;
  std::vector<std::string> sources;
  std::optional<std::string> frames;
  double framesPerSecond = 0;
  bool json = false, divergenceFree = false, curlFree = false;
  SampleOptions options;
};

void printText(const SampleReport& report, std::uint64_t bytes, double seconds) {
  for (const SampledFrame& frame : report.frames) {
    std::printf("%s  %s%s, %s voxels of %.4g, %.1f %% in the cage\n", frame.path.c_str(),
                frame.grid.c_str(), frame.staggered ? " (staggered)" : "",
                grouped(static_cast<std::int64_t>(frame.activeVoxels)).c_str(), frame.voxelSize,
                100 * frame.inside);
    std::printf(
        "  error %.2f %% of %.4g; divergence of the grid %.3g, of the form %.3g, written %.3g\n",
        100 * frame.error, frame.speed, frame.sourceDivergence, frame.before, frame.after);
  }
  std::printf("%s bytes became %s: 1 / %.1f; %.2f s\n",
              grouped(static_cast<std::int64_t>(report.sourceBytes)).c_str(),
              grouped(static_cast<std::int64_t>(bytes)).c_str(),
              static_cast<double>(report.sourceBytes) / static_cast<double>(bytes), seconds);
}

void printJson(const SampleReport& report, std::uint64_t bytes, double seconds) {
  using nlohmann::ordered_json;
  ordered_json frames = ordered_json::array();
  for (const SampledFrame& frame : report.frames) {
    ordered_json entry = {{"path", frame.path}, {"grid", frame.grid}};
    if (frame.frame) entry["frame"] = *frame.frame;
    entry["bytes"] = frame.bytes;
    entry["staggered"] = frame.staggered;
    entry["voxel_size"] = frame.voxelSize;
    entry["active_voxels"] = frame.activeVoxels;
    entry["inside"] = frame.inside;
    entry["speed"] = frame.speed;
    entry["error"] = frame.error;
    entry["source_divergence"] = frame.sourceDivergence;
    entry["before"] = frame.before;
    entry["after"] = frame.after;
    frames.push_back(std::move(entry));
  }
  const ordered_json document = {{"frames", std::move(frames)},
                                 {"source_bytes", report.sourceBytes},
                                 {"asset_bytes", bytes},
                                 {"seconds", seconds}};
  std::cout << text(document) << "\n";
}

void run(Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  SampleOptions& options = arguments.options;
  if (arguments.frames) options.frames = readFrames(*arguments.frames);
  checkSingleOutput(arguments.cage, arguments.output);
  if (arguments.divergenceFree && options.degree != 2) {
    throw InputError("--divergence-free", "is for fluxes, --degree 2");
  }
  if (arguments.curlFree && options.degree != 1) {
    throw InputError("--curl-free", "is for circulations, --degree 1");
  }
  options.closed = arguments.divergenceFree || arguments.curlFree;
  ControlAsset asset = readAsset(arguments.cage);
  if (arguments.framesPerSecond > 0) asset.units.framesPerSecond = arguments.framesPerSecond;
  options.read.framesPerSecond = asset.units.framesPerSecond;
  const SampleReport report = sampleVelocity(&asset, arguments.sources, options, consoleContext());
  writeControlAsset(asset, arguments.output, consoleContext());
  const std::uint64_t bytes = std::filesystem::file_size(arguments.output);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (arguments.json) {
    printJson(report, bytes, seconds);
  } else {
    printText(report, bytes, seconds);
  }
}

/// --velocity-unit
void addUnit(CLI::App* command, VelocityReadOptions* read) {
  const auto chosen = std::make_shared<VelocityUnit>();
  addChoice(command, "--velocity-unit", chosen.get(), velocityUnitChoices(),
            "What the grid's numbers mean; world units per second by default");
  command->parse_complete_callback([read, chosen] {
    read->voxels = chosen->voxels;
    read->perFrame = chosen->perFrame;
  });
}

}  // namespace

void addSample(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  SampleOptions& options = arguments->options;
  CLI::App* command = program->add_subcommand(
      "sample", "Turn velocity grids of a .vdb, or a sequence, into a form on a cage");
  command->add_option("CAGE", arguments->cage, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command
      ->add_option("VELOCITY", arguments->sources,
                   "Velocity .vdb; several, numbered, become an animation, as does vel.####.vdb")
      ->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "Control asset to write: the cage with the field")
      ->required();
  command->add_option("--frames", arguments->frames,
                      "Frames of vel.####.vdb, such as 1-10x2; all that are there by default");
  command->add_option("--grid", options.read.grid,
                      "Vector grid, or float triple NAME.x, NAME_x, NAMEX; velocity, vel or v by "
                      "default, or the only vector grid");
  command->add_option("--degree", options.degree, "2: fluxes through facets; 1: along edges")
      ->check(CLI::IsMember({1, 2}))
      ->capture_default_str();
  command->add_flag("--divergence-free", arguments->divergenceFree,
                    "Take the nearest field without divergence");
  command->add_flag("--curl-free", arguments->curlFree, "Take the nearest field without curl");
  addChoice(command, "--boundary-flux", &options.boundary, boundaryFluxChoices(),
            "What these do with coefficients on the boundary; obstacles: 0 on the "
            "walls of cavities, then "
            "bake with --boundary walls");
  command
      ->add_option("--corrections", options.corrections,
                   "How often coefficients are corrected by what the smooth limit lacks")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  addUnit(command, &options.read);
  command->add_option("--scale", options.read.scale, "Factor for the grid's numbers")
      ->capture_default_str();
  command
      ->add_option("--fps", arguments->framesPerSecond,
                   "Frames per second; those of the cage by default")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--levels", options.levels,
                   "Subdivisions at which the limit field is compared with the source")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  command
      ->add_option("--compare", options.mostPoints,
                   "Voxels of a frame at which they are compared, at most")
      ->check(CLI::Range(1, 1 << 30))
      ->capture_default_str();
  command->add_option("--name", options.name, "Name of the form to write")->capture_default_str();
  command->add_option("--zeta", options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
