// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include <octet/converters/vdb/merge_vdb.h>

#include "commands.h"
#include "console.h"
#include "file_text.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::vector<std::string> parts;
  std::string output;
  bool json = false;
};

void run(const Arguments& arguments) {
  for (const std::string& part : arguments.parts) checkSingleOutput(part, arguments.output);
  const BakedFile merged = mergeVdb(arguments.parts, arguments.output, consoleContext());
  if (arguments.json) {
    std::cout << text(toJson(merged)) << "\n";
  } else {
    print(merged);
  }
}

}  // namespace

void addMerge(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "merge", "Join the shards of a bake to the .vdb that it would have been without them");
  command
      ->add_option("PART", arguments->parts,
                   "The .vdb of each shard, in any order; of an animation, those of one frame")
      ->required();
  command->add_option("-o,--output", arguments->output, "The .vdb to write")->required();
  command->add_flag("--json", arguments->json, "Print a machine-readable summary");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
