// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/core/base/error.h>
#include <octet/core/forms/with_degree.h>
#ifdef OCTETVDB_WITH_THESIS
#include <octet/core/thesis/extension.h>
#include <octet/core/thesis/thesis_subdivision.h>
#endif

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string control, output;
  RefinerOptions options;
  BoundaryChoice boundary;
  std::optional<int> frame;
  bool json = false;
#ifdef OCTETVDB_WITH_THESIS
  bool virtualLayer = false;
#endif
};

/// More cells than this are refused, for memory and for the size of the document.
constexpr double kMostCells = 1e8;

/// A tetrahedron becomes four and an octahedron, an octahedron six and eight tetrahedra.
void checkSize(const Complex& control, int levels) {
  double tets = control.tetCount(), octs = control.octCount();
  for (int level = 0; level < levels; ++level) {
    const double coarseTets = tets;
    tets = 4 * tets + 8 * octs;
    octs = coarseTets + 6 * octs;
  }
  if (tets + octs > kMostCells) {
    throw InputError("--levels", std::to_string(levels) + " would make " +
                                     grouped(static_cast<std::int64_t>(tets + octs)) +
                                     " cells, more than " +
                                     grouped(static_cast<std::int64_t>(kMostCells)));
  }
}

void print(const Arguments& arguments, std::int64_t cells, const std::string& note) {
  if (arguments.json) {
    const nlohmann::ordered_json document = {{"path", arguments.output},
                                             {"levels", arguments.options.levels},
                                             {"cells", cells},
                                             {"boundary", arguments.boundary.name},
                                             {"note", note}};
    std::cout << text(document) << "\n";
  } else if (!note.empty()) {
    std::cout << "note: " << note << "\n";
  }
}

#ifdef OCTETVDB_WITH_THESIS
/// Writes the control mesh with the virtual layer of the expansion method around it, and the forms
/// continued to it (extension.h). The mesh's own vertices and cells come first, each kind.
void writeExpanded(const ControlAsset& asset, int frame, const Arguments& arguments,
                   const Context& context) {
  const VirtualLayer layer(asset.mesh);
  const ControlMesh expanded = ControlMesh::build(layer.expanded);
  const Extension extension(asset.mesh, layer, expanded);
  const auto values = [&](const Form& form) {
    return withDegree(form.degree, [&](auto degree) {
      return extension.apply(coefficients<decltype(degree)::value>(asset, form, frame)).values();
    });
  };
  writeRefinedDocument(asset, {*expanded.complex(), expanded.positions(), values}, arguments.output,
                       context);
}

void checkVirtualLayer(const Arguments& arguments) {
  if (arguments.virtualLayer && (arguments.boundary.name != methodName(ThesisMethod::Expansion) ||
                                 arguments.options.levels != 0)) {
    throw InputError("--virtual-layer", "needs --boundary expansion and --levels 0");
  }
}
#endif

void run(Arguments& arguments) {
  const RefinerOptions& options = arguments.options;
  const Context context = consoleContext();
  arguments.output = outputPath(arguments.output, arguments.frame);
  checkOutput(arguments.control, arguments.output);
#ifdef OCTETVDB_WITH_THESIS
  checkVirtualLayer(arguments);
#endif
  const ControlAsset asset = readAsset(arguments.control);
  checkSize(*asset.mesh.complex(), options.levels);
  if (arguments.frame) checkFrame(asset, *arguments.frame);
  const int frame = arguments.frame.value_or(0);
  const auto subdivision = arguments.boundary.subdivide(asset.mesh, options, context.sub(0.7));
#ifdef OCTETVDB_WITH_THESIS
  if (arguments.virtualLayer) {
    writeExpanded(asset, frame, arguments, context);
    print(arguments, subdivision->finest()->cellCount(), subdivision->note());
    return;
  }
#endif
  writeRefinedDocument(asset, *subdivision, arguments.boundary, frame, arguments.output, context);
  print(arguments, subdivision->finest()->cellCount(), subdivision->note());
}

}  // namespace

void checkFrame(const ControlAsset& asset, int frame) {
  const auto range = asset.frameRange();
  if (!range) throw InputError("--frame", "the asset's forms are not animated");
  if (frame < range->first || frame > range->second) {
    throw InputError("--frame", "the asset has frames " + std::to_string(range->first) + "-" +
                                    std::to_string(range->second));
  }
}

void addRefine(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "refine", "Write the subdivided complex and coefficients as a JSON document");
  command
      ->add_option("CONTROL", arguments->control, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command->add_option("-o,--output", arguments->output, "Document to write (.json, or .cbor)")
      ->required();
  command->add_option("--levels", arguments->options.levels, "Subdivisions")
      ->check(CLI::Range(0, 12))
      ->required();
  addBoundary(command, &arguments->boundary, true);
  addWallSurface(command, &arguments->options.boundaryRows);
  command
      ->add_option("--zeta", arguments->options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_flag("!--linear", arguments->options.smooth,
                    "Linear (Whitney) subdivision only, without smoothing");
  command->add_option("--frame", arguments->frame, "Frame of an animated asset");
#ifdef OCTETVDB_WITH_THESIS
  command->add_flag("--virtual-layer", arguments->virtualLayer,
                    "Write the control mesh with the layer that --boundary expansion puts around "
                    "it, and the forms continued to it");
#endif
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
