// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/core/base/error.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string control, output;
  RefinerOptions options;
  BoundaryChoice boundary = BoundaryChoice::Auto;
  int frame = 0;
};

void run(Arguments& arguments) {
  arguments.options.progress = consoleProgress();
  const ControlAsset asset = readAsset(arguments.control);
  const Refiner refiner(asset.mesh, arguments.options);
  writeRefinedDocument(asset, refiner, arguments.boundary, arguments.frame, arguments.output);
}

}  // namespace

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
  const std::map<std::string, BoundaryChoice> boundaries = {{"auto", BoundaryChoice::Auto},
                                                            {"walls", BoundaryChoice::Walls},
                                                            {"open", BoundaryChoice::Open}};
  command->add_option("--boundary", arguments->boundary, "Boundary mode, see bake")
      ->transform(CLI::CheckedTransformer(boundaries, CLI::ignore_case))
      ->option_text("auto|walls|open");
  command
      ->add_option("--zeta", arguments->options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_option("--frame", arguments->frame, "Frame of an animated asset");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
