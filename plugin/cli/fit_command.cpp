// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/guides/guide_file.h>
#include <octet/core/base/error.h>
#include <octet/core/fit/fit.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string cage, output, name = "velocity", potential, flux;
  std::vector<std::string> guides;
  double speed = 1;
  bool divergenceFree = false, curlFree = false, free = false, json = false;
  FitOptions options;
};

Guides readAll(const Arguments& arguments) {
  Guides all;
  for (const std::string& path : arguments.guides) {
    Guides guides = readGuides(path, arguments.speed);
    std::move(guides.curves.begin(), guides.curves.end(), std::back_inserter(all.curves));
    std::move(guides.vectors.begin(), guides.vectors.end(), std::back_inserter(all.vectors));
  }
  return all;
}

/// Puts a form into the asset, in place of one of the same name.
void put(ControlAsset* asset, Form form) {
  auto& forms = asset->forms;
  const auto same = std::find_if(forms.begin(), forms.end(),
                                 [&](const Form& other) { return other.name == form.name; });
  if (same != forms.end()) {
    *same = std::move(form);
  } else {
    forms.push_back(std::move(form));
  }
}

void putResult(ControlAsset* asset, const Arguments& arguments, const FitResult& result) {
  if (result.flux) {
    put(asset, makeForm<2>(arguments.name, *result.flux, "1/s"));
  } else {
    put(asset, makeForm<1>(arguments.name, *result.circulation, "1/s"));
  }
  if (arguments.potential.empty()) return;
  if (result.vectorPotential) {
    put(asset, makeForm<1>(arguments.potential, *result.vectorPotential, "1/s"));
  } else if (result.potential) {
    put(asset, makeForm<0>(arguments.potential, *result.potential, "1/s"));
  } else {
    throw InputError("--potential",
                     "a field that is neither divergence-free nor curl-free has none");
  }
}

void printText(const FitReport& report, BoundaryMode mode, double seconds) {
  std::size_t widest = 5;
  for (const GuideReport& guide : report.guides) widest = std::max(widest, guide.name.size());
  std::printf("%-*s  samples  residual    worst\n", static_cast<int>(widest), "guide");
  for (const GuideReport& guide : report.guides) {
    std::printf("%-*s  %7zu  %7.3f %%  %6.2f %%\n", static_cast<int>(widest), guide.name.c_str(),
                guide.samples, 100 * guide.residual, 100 * guide.worst);
  }
  std::printf(
      "all guides: %.3f %%; %zu equations, %s unknowns, %s\n", 100 * report.residual,
      report.equations, grouped(report.unknowns).c_str(),
      report.direct ? "factorised" : (std::to_string(report.iterations) + " iterations").c_str());
  std::printf("flow through walls %.3g, divergence %.3g (relative); bake with --boundary %s\n",
              report.wallFlux, report.divergence, mode == BoundaryMode::Walls ? "walls" : "open");
  for (const GuideConflict& conflict : report.conflicts) {
    std::printf(
        "conflict: \"%s\" and \"%s\" differ by %.0f %% near (%.4g, %.4g, %.4g); missed by %.0f "
        "%%\n",
        conflict.first.c_str(), conflict.second.c_str(), 100 * conflict.disagreement,
        conflict.point[0], conflict.point[1], conflict.point[2], 100 * conflict.residual);
  }
  for (const std::string& remark : report.remarks) std::printf("note: %s\n", remark.c_str());
  std::printf("%.2f s\n", seconds);
}

void printJson(const FitReport& report, BoundaryMode mode, double seconds) {
  using nlohmann::ordered_json;
  ordered_json guides = ordered_json::array(), conflicts = ordered_json::array();
  for (const GuideReport& guide : report.guides) {
    guides.push_back({{"name", guide.name},
                      {"samples", guide.samples},
                      {"residual", guide.residual},
                      {"worst", guide.worst}});
  }
  for (const GuideConflict& conflict : report.conflicts) {
    conflicts.push_back({{"first", conflict.first},
                         {"second", conflict.second},
                         {"point", {conflict.point[0], conflict.point[1], conflict.point[2]}},
                         {"disagreement", conflict.disagreement},
                         {"residual", conflict.residual}});
  }
  const ordered_json document = {{"guides", std::move(guides)},
                                 {"residual", report.residual},
                                 {"conflicts", std::move(conflicts)},
                                 {"remarks", report.remarks},
                                 {"equations", report.equations},
                                 {"unknowns", report.unknowns},
                                 {"direct", report.direct},
                                 {"iterations", report.iterations},
                                 {"solver_residual", report.solverResidual},
                                 {"wall_flux", report.wallFlux},
                                 {"divergence", report.divergence},
                                 {"boundary", mode == BoundaryMode::Walls ? "walls" : "open"},
                                 {"seconds", seconds}};
  std::cout << text(document) << "\n";
}

void run(Arguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  FitOptions& options = arguments.options;
  options.kind = arguments.curlFree ? FitKind::CurlFree
                 : arguments.free   ? FitKind::Free
                                    : FitKind::DivergenceFree;
  checkSingleOutput(arguments.cage, arguments.output);
  if (arguments.potential == arguments.name) {
    throw InputError("--potential", "has the name of the field itself");
  }
  ControlAsset asset = readAsset(arguments.cage);
  const Guides guides = readAll(arguments);
  if (!arguments.flux.empty()) options.flux = readGivenFlux(arguments.flux, asset.mesh);
  const Context context = consoleContext();
  const FitResult result = Fit(asset.mesh, options, context.sub(0.5)).solve(guides, context);
  putResult(&asset, arguments, result);
  writeControlAsset(asset, arguments.output);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (arguments.json) {
    printJson(result.report, result.mode, seconds);
  } else {
    printText(result.report, result.mode, seconds);
  }
}

}  // namespace

void addFit(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  FitOptions& options = arguments->options;
  CLI::App* command = program->add_subcommand(
      "fit", "Find the smooth field that follows guide curves and vectors best");
  command->add_option("CAGE", arguments->cage, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "Control asset to write: the cage with the field")
      ->required();
  command
      ->add_option("--guides", arguments->guides,
                   "Guides: .obj (polylines), .csv or .json; may be repeated")
      ->allow_extra_args(false)
      ->required();
  command->add_option("--speed", arguments->speed, "Speed of curves that state none, units/s")
      ->capture_default_str();
  auto* divergenceFree = command->add_flag("--divergence-free", arguments->divergenceFree,
                                           "A field without divergence (default)");
  auto* curlFree =
      command->add_flag("--curl-free", arguments->curlFree, "The gradient of a potential")
          ->excludes(divergenceFree);
  command->add_flag("--free", arguments->free, "Neither")
      ->excludes(divergenceFree)
      ->excludes(curlFree);
  addChoice<bool>(command, "--walls", &options.closedWalls, {{"closed", true}, {"open", false}},
                  "closed (default): nothing passes the boundary; open: no condition there");
  command->add_option("--flux", arguments->flux,
                      "Given flux through boundary facets: JSON with simplices and values");
  command
      ->add_option("--smoothness", options.smoothness,
                   "Details smaller than this share of the domain's size are smoothed away")
      ->capture_default_str();
  command
      ->add_option("--levels", options.levels,
                   "Subdivisions at which the limit field is compared with guides")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  command->add_option("--spacing", options.spacing,
                      "Distance of samples along curves; a quarter of the cage's mean edge");
  command->add_option("--name", arguments->name, "Name of the form to write")
      ->capture_default_str();
  command->add_option("--potential", arguments->potential,
                      "Write the potential, too, as a form of this name");
  command->add_option("--zeta", options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
