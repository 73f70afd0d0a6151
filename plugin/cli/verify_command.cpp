// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include <octet/core/base/error.h>

#include "certificate_text.h"
#include "commands.h"
#include "console.h"
#include "failure.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string path, grid;
  std::optional<double> maxDivergence;
  bool json = false;
};

nlohmann::ordered_json documentOf(const Arguments& arguments,
                                  const std::vector<VerifiedGrid>& grids) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const VerifiedGrid& grid : grids) {
    list.push_back({{"name", grid.name},
                    {"type", grid.type},
                    {"class", grid.gridClass},
                    {"voxel_size", grid.voxelSize},
                    {"certificate", cli::toJson(grid.certificate)}});
  }
  return {{"path", arguments.path}, {"grids", std::move(list)}};
}

void print(const std::vector<VerifiedGrid>& grids) {
  for (const VerifiedGrid& grid : grids) {
    std::printf("%s  %s, %s, voxel %.4g\n", grid.name.c_str(), grid.type.c_str(),
                grid.gridClass.c_str(), grid.voxelSize);
    printCertificate(grid.certificate, "  ");
  }
}

/// The first grid that does not keep the limit.
std::optional<Error> failureOfLimit(const Arguments& arguments,
                                    const std::vector<VerifiedGrid>& grids) {
  if (!arguments.maxDivergence) return std::nullopt;
  for (const VerifiedGrid& grid : grids) {
    // Not "greater": what is no number is no pass.
    if (grid.certificate.maxDivergence <= *arguments.maxDivergence) continue;
    char reason[120];
    std::snprintf(reason, sizeof reason, "the largest divergence, %.3g, is above %.3g",
                  grid.certificate.maxDivergence, *arguments.maxDivergence);
    return Error(arguments.path, grid.name, reason);
  }
  return std::nullopt;
}

void run(const Arguments& arguments) {
  const std::vector<VerifiedGrid> grids =
      verifyVdb(arguments.path, arguments.grid, consoleContext());
  const std::optional<Error> failure = failureOfLimit(arguments, grids);
  if (!arguments.json) {
    print(grids);
    if (failure) throw *failure;
    return;
  }
  nlohmann::ordered_json document = documentOf(arguments, grids);
  if (failure) document["error"] = toJson(failureOf(*failure));
  std::cout << text(document) << "\n";
  if (failure) throw AlreadyTold{tell(failureOf(*failure), false)};
}

std::string checkLimit(const std::string& text) {
  double x = 0;
  const bool valid = CLI::detail::lexical_cast(text, x) && x >= 0 && std::isfinite(x);
  return valid ? "" : "\"" + text + "\" is not a number from 0";
}

}  // namespace

void addVerify(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "verify",
      "Measure divergence and curl of any .vdb's vector grids with OpenVDB's own operators");
  command->add_option("FILE", arguments->path, "A .vdb, whoever wrote it")->required();
  command->add_option("--grid", arguments->grid,
                      "Only this vector grid, or triple of float grids; all by default");
  command
      ->add_option("--max-divergence", arguments->maxDivergence,
                   "Fail, with exit code 1, above this: divergence times voxel size over the "
                   "largest speed")
      ->check(checkLimit);
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
