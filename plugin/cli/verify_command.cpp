// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>

#include <octet/core/base/error.h>

#include "certificate_text.h"
#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string path, grid;
  std::optional<double> maxDivergence;
  bool json = false;
};

void print(const Arguments& arguments, const std::vector<VerifiedGrid>& grids) {
  if (arguments.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const VerifiedGrid& grid : grids) {
      list.push_back({{"name", grid.name},
                      {"type", grid.type},
                      {"class", grid.gridClass},
                      {"voxel_size", grid.voxelSize},
                      {"certificate", toJson(grid.certificate)}});
    }
    std::cout << text({{"path", arguments.path}, {"grids", std::move(list)}}) << "\n";
    return;
  }
  for (const VerifiedGrid& grid : grids) {
    std::printf("%s  %s, %s, voxel %.4g\n", grid.name.c_str(), grid.type.c_str(),
                grid.gridClass.c_str(), grid.voxelSize);
    printCertificate(grid.certificate, "  ");
  }
}

void run(const Arguments& arguments) {
  const std::vector<VerifiedGrid> grids =
      verifyVdb(arguments.path, arguments.grid, consoleContext());
  print(arguments, grids);
  if (!arguments.maxDivergence) return;
  for (const VerifiedGrid& grid : grids) {
    // Not "greater": what is no number is no pass.
    if (grid.certificate.maxDivergence <= *arguments.maxDivergence) continue;
    char reason[120];
    std::snprintf(reason, sizeof reason, "the largest divergence, %.3g, is above %.3g",
                  grid.certificate.maxDivergence, *arguments.maxDivergence);
    throw Error(arguments.path, grid.name, reason);
  }
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
