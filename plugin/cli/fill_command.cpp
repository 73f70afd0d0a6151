// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/gmsh/fill_tetrahedra.h>
#include <octet/converters/surface/fill_surface.h>
#include <octet/converters/surface/read_surface.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>
#include <octet/core/cage/sharp_edges.h>

#include "commands.h"
#include "console.h"
#include "mesh_report.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

enum class Cells { Lattice, Tetrahedra };

struct Arguments {
  std::string input, output, name;
  std::vector<double> box;
  Cells cells = Cells::Lattice;
  SurfaceReadOptions read;
  FillOptions fill;
  bool keepTriangles = false;
  AssetUnits units;
  bool json = false;
  std::vector<const CLI::Option*> ofLattice, ofTetrahedra;  ///< options of one kind of cells
};

Box boxOf(const Arguments& arguments) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    box.min[k] = arguments.box[k];
    box.max[k] = arguments.box[k + 3];
  }
  return box;
}

Json fillBox(const Arguments& arguments, ControlMesh* mesh) {
  const Box box = boxOf(arguments);
  *mesh = ControlMesh::build(boxCage(box, arguments.fill.spacing), consoleContext());
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

/// An error of a fill, by the option or the file that it is about.
InputError asUserSees(const InputError& e, const std::string& input) {
  if (e.place() == "spacing" || e.place() == "sharp-angle") {
    return InputError("--" + e.place(), e.reason());
  }
  if (e.place() == "fit") return InputError("--fit-boundary", e.reason());
  return input.empty() ? InputError("--box", e.reason()) : e.inFile(input);
}

Json fillTetrahedra(const Arguments& arguments, ControlMesh* mesh) {
  TetrahedraOptions options;
  options.spacing = arguments.fill.spacing;
  options.sharpAngle = arguments.fill.sharpAngle;
  options.keepTriangles = arguments.keepTriangles;
  TetrahedraReport report;
  std::size_t triangles = 0;
  try {
    const TriangleSurface surface = arguments.input.empty()
                                        ? boxSurface(boxOf(arguments))
                                        : readSurface(arguments.input, arguments.read);
    triangles = surface.triangles.size();
    *mesh = fillWithTetrahedra(surface, options, &report, consoleContext());
  } catch (const InputError& e) {
    throw e.file().empty() ? asUserSees(e, arguments.input) : e;
  }
  return {{"surface_triangles", triangles},
          {"bodies", report.bodies},
          {"cavities", report.cavities},
          {"body_volume", report.bodyVolume},
          {"boundary", report.remeshed ? "remeshed" : "the surface's triangles"},
          {"max_facet_distance", report.surfaceDistance},
          {"sharp_length", report.sharpLength},
          {"crease_length", report.creaseLength}};
}

Json fillInput(const Arguments& arguments, ControlMesh* mesh) {
  const TriangleSurface surface = readSurface(arguments.input, arguments.read);
  FillReport report;
  try {
    *mesh = fillSurface(surface, arguments.fill, &report, consoleContext());
  } catch (const InputError& e) {
    throw asUserSees(e, arguments.input);
  }
  Json summary = {{"surface_triangles", surface.triangles.size()},
                  {"bodies", report.bodies},
                  {"cavities", report.cavities},
                  {"body_volume", report.bodyVolume},
                  {"interior_vertices", report.lattice.interiorVertices},
                  {"components", report.lattice.components},
                  {"vertices_added_for_a_manifold", report.lattice.added},
                  {"vertices_dropped_for_a_manifold", report.lattice.dropped}};
  if (report.fit) {
    summary["fit"] = toJson(*report.fit);
    summary["sharp_length"] = report.sharpLength;
    summary["crease_length"] = report.creaseLength;
  }
  return summary;
}

void checkArguments(const Arguments& arguments) {
  if (arguments.input.empty() == arguments.box.empty()) {
    throw InputError("", "fill takes either INPUT or --box");
  }
  const bool lattice = arguments.cells == Cells::Lattice;
  for (const CLI::Option* option : lattice ? arguments.ofTetrahedra : arguments.ofLattice) {
    if (option->count() == 0) continue;
    throw InputError(option->get_name(),
                     std::string("is for --cells ") + (lattice ? "tetrahedra" : "lattice"));
  }
  if (!(arguments.fill.depth >= 0.1 && arguments.fill.depth <= 2)) {
    throw InputError("--depth", "is not between 0.1 and 2");
  }
  checkSingleOutput(arguments.input, arguments.output);
}

void run(Arguments& arguments) {
  checkArguments(arguments);
  ControlAsset asset;
  Json summary = {{"output", arguments.output}};
  const auto fill = arguments.cells == Cells::Tetrahedra ? fillTetrahedra
                    : arguments.box.empty()              ? fillInput
                                                         : fillBox;
  summary["fill"] = fill(arguments, &asset.mesh);
  asset.name = arguments.name;
  if (asset.name.empty()) {
    const std::string stem = std::filesystem::path(arguments.output).filename().string();
    asset.name = stem.substr(0, stem.find('.'));
  }
  asset.units = arguments.units;
  summary.update(describeMesh(asset.mesh));
  writeControlAsset(asset, arguments.output, consoleContext());
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
  command->add_option("--spacing", arguments->fill.spacing, "Edge length of cells, world units")
      ->required();
  addChoice<Cells>(command, "--cells", &arguments->cells,
                   {{"lattice", Cells::Lattice}, {"tetrahedra", Cells::Tetrahedra}},
                   "The regular lattice of tetrahedra and octahedra, or tetrahedra made by Gmsh, "
                   "whose boundary follows sharp edges exactly");
  command
      ->add_option("--sharp-angle", arguments->fill.sharpAngle,
                   "Edges where the surface turns by more, in degrees, become creases")
      ->capture_default_str();
  arguments->ofTetrahedra = {
      command->add_flag("--keep-triangles", arguments->keepTriangles,
                        "Tetrahedra: take the surface's triangles as they are; by default they "
                        "are remeshed unless about as large as the spacing")};
  arguments->ofLattice = {
      command
          ->add_option("--depth", arguments->fill.depth,
                       "Lattice: how deep inside, in spacings, interior vertices lie at least")
          ->capture_default_str(),
      command->add_flag("--fit-boundary", arguments->fill.fitBoundary,
                        "Lattice: move boundary vertices onto the surface and its sharp edges, "
                        "inverting no cell"),
      command->add_option("--fit-rounds", arguments->fill.fit.rounds, "Sweeps of --fit-boundary")
          ->check(CLI::Range(1, 10000))
          ->capture_default_str(),
      command->add_flag(
          "--allow-self-intersections", arguments->fill.allowIntersections,
          "Lattice: fill what a surface that intersects itself encloses, instead of refusing it")};
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
