// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <octet/core/boundary_methods/method_refiner.h>
#include <octet/core/refine/refiner.h>

#include "control_asset.h"

namespace octet {

/// How an asset's forms meet the boundary: as each form says (automaticMode), or all alike; the
/// last three are the thesis' methods.
enum class BoundaryChoice : std::uint8_t { Auto, Walls, Open, Simple, Projection, Expansion };

/// The thesis' method that a choice stands for, if it does: then MethodRefiner takes the place of
/// Refiner.
std::optional<BoundaryMethod> boundaryMethod(BoundaryChoice choice);
/// The name that commands and files know a choice by.
const char* boundaryName(BoundaryChoice choice);

/// The mode for one form; of an animated form, one mode for all frames.
BoundaryMode boundaryMode(const ControlAsset& asset, const Form& form, BoundaryChoice choice);

/// What one of the thesis' methods does not keep on the mesh that it was made for; empty when it
/// keeps all that it claims.
std::string methodNote(const MethodRefiner& refiner);

/// Writes the finest complex of a refiner and the asset's forms on it: vertices, edges, facets,
/// tetrahedra, octahedra, and for each form its degree and dense values (of frame `frame`).
/// @throws IoError, Cancelled
void writeRefinedDocument(const ControlAsset& asset, const Refiner& refiner, BoundaryChoice choice,
                          int frame, const std::string& path,
                          const ProgressCallback& progress = {});
/// The same by one of the thesis' boundary methods; `note` says what it does not keep, if anything.
void writeRefinedDocument(const ControlAsset& asset, const MethodRefiner& refiner, int frame,
                          const std::string& path, const ProgressCallback& progress = {});
/// The control mesh with the virtual layer of the expansion method around it, and the forms
/// continued to it (extension.h). Vertices and cells of the mesh itself come first, each kind.
void writeExpandedDocument(const ControlAsset& asset, int frame, const std::string& path,
                           const ProgressCallback& progress = {});

}  // namespace octet
