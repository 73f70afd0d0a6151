// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/surface/fill_surface.h>
#include <octet/converters/surface/read_surface.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>

#include "commands.h"
#include "console.h"
#include "mesh_report.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string input, output, name;
  std::vector<double> box;
  SurfaceReadOptions read;
  FillOptions fill;
  AssetUnits units;
  bool json = false;
};

Json fillBox(const Arguments& arguments, ControlMesh* mesh) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = arguments.box[k];
    box.max[k] = arguments.box[k + 3];
  }
  *mesh = ControlMesh::build(boxCage(box, arguments.fill.spacing));
  return {{"body_volume", box.size().prod()}};
}

Json toJson(const BoundaryFitReport& fit) {
  return {{"mean_distance_before", fit.meanBefore},
          {"max_distance_before", fit.maxBefore},
          {"mean_distance", fit.meanAfter},
          {"max_distance", fit.maxAfter},
          {"vertices_off_surface", fit.offSurface.size()},
          {"mean_facet_distance", fit.meanFacet},
          {"max_facet_distance", fit.maxFacet},
          {"smallest_corner_volume", fit.minVolume}};
}

Json fillInput(const Arguments& arguments, ControlMesh* mesh) {
  const TriangleSurface surface = readSurface(arguments.input, arguments.read);
  FillReport report;
  try {
    *mesh = fillSurface(surface, arguments.fill, &report);
  } catch (const InputError& e) {
    throw e.place() == "spacing" ? InputError("--spacing", e.reason())
    : e.place() == "fit"         ? InputError("--fit-boundary", e.reason())
                                 : e.inFile(arguments.input);
  }
  Json summary = {{"surface_triangles", surface.triangles.size()},
                  {"bodies", report.bodies},
                  {"cavities", report.cavities},
                  {"body_volume", report.bodyVolume},
                  {"interior_vertices", report.lattice.interiorVertices},
                  {"components", report.lattice.components},
                  {"vertices_added_for_a_manifold", report.lattice.added},
                  {"vertices_dropped_for_a_manifold", report.lattice.dropped}};
  if (report.fit) summary["fit"] = toJson(*report.fit);
  return summary;
}

void checkArguments(const Arguments& arguments) {
  if (arguments.input.empty() == arguments.box.empty()) {
    throw InputError("", "fill takes either INPUT or --box");
  }
  if (!(arguments.fill.depth >= 0.1 && arguments.fill.depth <= 2)) {
    throw InputError("--depth", "is not between 0.1 and 2");
  }
  checkOutput(arguments.input, arguments.output);
}

void run(Arguments& arguments) {
  checkArguments(arguments);
  arguments.fill.progress = consoleProgress();
  ControlAsset asset;
  Json summary = {{"output", arguments.output}};
  summary["fill"] =
      arguments.box.empty() ? fillInput(arguments, &asset.mesh) : fillBox(arguments, &asset.mesh);
  asset.name = arguments.name;
  if (asset.name.empty()) {
    const std::string stem = std::filesystem::path(arguments.output).filename().string();
    asset.name = stem.substr(0, stem.find('.'));
  }
  asset.units = arguments.units;
  summary.update(describeMesh(asset.mesh));
  writeControlAsset(asset, arguments.output);
  if (arguments.json) {
    std::cout << text(summary) << "\n";
  } else {
    printPlain(summary);
  }
}

}  // namespace

void addFill(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "fill", "Make a cage that fills a box, a closed surface or a level set");
  command->add_option("INPUT", arguments->input,
                      "Closed surface (.obj, .stl), or level set or fog volume (.vdb)");
  command->add_option("--box", arguments->box, "Fill a box instead: x0 y0 z0 x1 y1 z1")
      ->expected(6);
  command->add_option("-o,--output", arguments->output, "Cage to write (*.octet.json, *.octet)")
      ->required();
  command
      ->add_option("--spacing", arguments->fill.spacing, "Edge length of the lattice, world units")
      ->required();
  command
      ->add_option("--depth", arguments->fill.depth,
                   "How deep inside, in spacings, interior vertices lie at least")
      ->capture_default_str();
  command->add_flag("--fit-boundary", arguments->fill.fitBoundary,
                    "Move boundary vertices onto the surface, inverting no cell");
  command->add_option("--fit-rounds", arguments->fill.fit.rounds, "Sweeps of --fit-boundary")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--allow-self-intersections", arguments->fill.allowIntersections,
                    "Fill what a surface that intersects itself encloses, instead of refusing it");
  command->add_option("--grid", arguments->read.grid,
                      "Grid of a .vdb; the first scalar one by default");
  command->add_option("--isovalue", arguments->read.isovalue,
                      "Value on the surface of a .vdb; by default 0 for a level set, else half of "
                      "the largest");
  command->add_option("--name", arguments->name, "Name of the asset; the file's by default");
  addChoice<char>(command, "--up-axis", &arguments->units.upAxis, {{"y", 'Y'}, {"z", 'Z'}},
                  "Up axis of the asset; coordinates stay as they are");
  command->add_flag("--json", arguments->json, "Print the summary as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
