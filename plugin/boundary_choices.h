// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <octet/converters/control_asset/refined_document.h>
#ifdef OCTETVDB_WITH_THESIS
#include <octet/core/thesis/thesis_subdivision.h>
#endif

namespace octet {

/// The names by which the command and the Python module choose what happens at the boundary, and
/// what they stand for. @param methods  with those of the thesis, where they were built
inline std::vector<std::pair<std::string, BoundaryChoice>> boundaryChoices(bool methods) {
  std::vector<BoundaryChoice> choices = {
      {"auto", {}}, {"walls", BoundaryMode::Walls}, {"open", BoundaryMode::Open}};
#ifdef OCTETVDB_WITH_THESIS
  for (const auto method :
       {ThesisMethod::Simple, ThesisMethod::Projection, ThesisMethod::Expansion}) {
    if (!methods) break;
    const auto subdivide = [method](const ControlMesh& mesh, const RefinerOptions& options,
                                    const Context& context) {
      return subdivideByThesis(mesh, method, options, context);
    };
    choices.push_back({methodName(method), {}, subdivide});
  }
#else
  (void)methods;
#endif
  std::vector<std::pair<std::string, BoundaryChoice>> named;
  for (BoundaryChoice& choice : choices) {
    std::string name = choice.name;
    named.emplace_back(std::move(name), std::move(choice));
  }
  return named;
}

/// The names by which they choose the wall's surface.
inline std::vector<std::pair<std::string, BoundaryRows>> wallSurfaceChoices() {
  return {{"smooth", BoundaryRows::Smooth}, {"loop", BoundaryRows::Loop}};
}

}  // namespace octet
