// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <octet/core/field/scheme_subdivision.h>

#include "control_asset.h"

namespace octet {

/// By which rule an asset's forms are subdivided, and how they meet the boundary.
struct BoundaryChoice {
  std::string name = "auto";           ///< what users know it by
  std::optional<BoundaryMode> mode{};  ///< of all forms alike; absent: as each says (automaticMode)
  Subdivide subdivide = subdivideByScheme;
};

/// The boundary mode for one form; of an animated form, one for all frames.
BoundaryMode boundaryMode(const ControlAsset& asset, const Form& form,
                          const BoundaryChoice& choice);

/// A mesh and forms on it, to be written as a document.
struct RefinedForms {
  const Complex& complex;
  const Array<Vec3>& positions;                           ///< of vertices, world units
  std::function<Array<double>(const Form& form)> values;  ///< dense coefficients on `complex`
  std::string note{};  ///< what is to be said of them, if anything
};

/// Writes vertices, edges, facets, tetrahedra, octahedra, and for each of the asset's forms its
/// degree and dense values. @throws IoError, Cancelled
void writeRefinedDocument(const ControlAsset& asset, const RefinedForms& refined,
                          const std::string& path, const Context& context = {});

/// Writes the finest level of a subdivision of the asset's mesh, with the asset's forms on it.
/// @param frame  of animated forms
/// @throws IoError, Cancelled
void writeRefinedDocument(const ControlAsset& asset, const Subdivision& subdivision,
                          const BoundaryChoice& boundary, int frame, const std::string& path,
                          const Context& context = {});

}  // namespace octet
