// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <utility>
#include <vector>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/core/base/suggestion.h>

#include "../choices.h"

/// @file
/// The subcommands of octetvdb: each adds itself to the program and runs when it was chosen.

namespace octet::cli {

void addAdd(CLI::App* program);
void addAnalyse(CLI::App* program);
void addBake(CLI::App* program);
void addFill(CLI::App* program);
void addFit(CLI::App* program);
void addInfo(CLI::App* program);
void addMerge(CLI::App* program);
#ifdef OCTETVDB_WITH_PICTURES
void addPreview(CLI::App* program);
#endif
void addRefine(CLI::App* program);
void addSample(CLI::App* program);
void addVerify(CLI::App* program);

/// Adds an option that takes one of some names, in any case.
template <typename T>
void addChoice(CLI::App* command, const std::string& option, T* value, const Choices<T>& choices,
               const std::string& help) {
  std::string alternatives;
  for (const auto& [name, choice] : choices) {
    alternatives += (alternatives.empty() ? "" : "|") + name;
  }
  const std::vector<std::string> names = namesOf(choices);
  const auto choose = [=](const std::string& text) {
    for (const auto& [name, choice] : choices) {
      if (CLI::detail::to_lower(text) != name) continue;
      *value = choice;
      return;
    }
    throw CLI::ValidationError(
        option, "\"" + text + "\" is none of " + listOf(names) + didYouMean(text, names));
  };
  command->add_option_function<std::string>(option, choose, help)->option_text(alternatives);
}

/// Adds --boundary; `methods`: with those of the thesis.
void addBoundary(CLI::App* command, BoundaryChoice* choice, bool methods = false);

/// Adds --wall-surface.
void addWallSurface(CLI::App* command, BoundaryRows* rows);

/// Refuses a --frame that the asset does not have.
void checkFrame(const ControlAsset& asset, int frame);

}  // namespace octet::cli
