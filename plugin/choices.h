// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/converters/vdb/bake_options.h>
#include <octet/converters/vdb/targets.h>
#include <octet/converters/vdb_sampling/sample_velocity.h>
#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>
#ifdef OCTETVDB_WITH_THESIS
#include <octet/core/thesis/thesis_subdivision.h>
#endif

/// @file
/// The names by which the command and the Python module choose, and what they stand for: each said
/// here alone.

namespace octet {

/// What names stand for.
template <typename T>
using Choices = std::vector<std::pair<std::string, T>>;

template <typename T>
std::vector<std::string> namesOf(const Choices<T>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, choice] : choices) names.push_back(name);
  return names;
}

/// What happens at the boundary. @param methods  with those of the thesis, where they were built
inline Choices<BoundaryChoice> boundaryChoices(bool methods) {
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
  Choices<BoundaryChoice> named;
  for (BoundaryChoice& choice : choices) {
    std::string name = choice.name;
    named.emplace_back(std::move(name), std::move(choice));
  }
  return named;
}

inline Choices<BoundaryRows> wallSurfaceChoices() {
  return {{"smooth", BoundaryRows::Smooth}, {"loop", BoundaryRows::Loop}};
}

inline Choices<Sampling> samplingChoices() {
  return {{"collocated", Sampling::Collocated}, {"staggered", Sampling::Staggered}};
}

inline Choices<Reconstruction> reconstructionChoices() {
  return {{"limit", Reconstruction::Limit}, {"whitney", Reconstruction::Whitney}};
}

inline Choices<BakeMethod> methodChoices() {
  return {{"auto", BakeMethod::Auto},
          {"conservative", BakeMethod::Conservative},
          {"samples", BakeMethod::Samples}};
}

/// Names of targets, which stand for themselves.
inline Choices<std::string> targetChoices() {
  Choices<std::string> choices;
  for (const Target& target : targets()) choices.emplace_back(target.name, target.name);
  return choices;
}

/// What nearest closed forms do at the boundary.
inline Choices<BoundaryRule> boundaryFluxChoices() {
  return {{"free", BoundaryRule::Free},
          {"keep", BoundaryRule::Keep},
          {"zero", BoundaryRule::Zero},
          {"obstacles", BoundaryRule::ZeroInside}};
}

/// What a velocity grid's numbers count: voxels or world units, per frame or second.
struct VelocityUnit {
  bool voxels = false, perFrame = false;
};
inline Choices<VelocityUnit> velocityUnitChoices() {
  return {{"units/s", {false, false}},
          {"units/frame", {false, true}},
          {"voxels/s", {true, false}},
          {"voxels/frame", {true, true}}};
}

/// Finds what a name stands for. @throws InputError listing the names there are
template <typename T>
T choose(const char* argument, const std::string& name, const Choices<T>& choices) {
  for (const auto& [known, value] : choices) {
    if (name == known) return value;
  }
  const std::vector<std::string> names = namesOf(choices);
  throw InputError(argument,
                   "\"" + name + "\" is none of " + listOf(names) + didYouMean(name, names));
}

}  // namespace octet
