// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/cage/boundary_fit.h>
#include <octet/core/cage/lattice_fill.h>
#include <octet/core/cage/sharp_edges.h>
#include <octet/core/cage/triangle_surface.h>

namespace octet {

struct FillOptions {
  double spacing = 0;  ///< edge length of the lattice, world units
  /// Interior vertices lie deeper than this, in spacings (lattice_fill.h).
  double depth = 0.5;
  /// Take a surface that passes through itself for the body it encloses, instead of refusing it.
  bool allowIntersections = false;
  bool fitBoundary = false;  ///< move boundary vertices onto the surface (boundary_fit.h)
  BoundaryFitOptions fit;
  /// Of a fit: edges at which the surface turns by more, in degrees, are followed by creases as far
  /// as no cell is inverted; 180 makes none.
  double sharpAngle = kSharpAngle;
};

struct FillReport {
  LatticeFillReport lattice;
  double bodyVolume = 0;  ///< of what the surface encloses, less cavities
  Index bodies = 0, cavities = 0;
  std::optional<BoundaryFitReport> fit;
  double sharpLength = 0, creaseLength = 0;  ///< of a fit: sharp edges there are, and creases made
};

/// @brief A control mesh that fills a closed surface with the regular lattice (lattice_fill.h),
/// inside and outside told by OpenVDB's meshToVolume. A part of the surface within another is a
/// cavity, one within a cavity a body again, whichever way the triangles are oriented.
/// @throws InputError for a surface that is not closed, intersects itself or is thinner everywhere
/// than the lattice can fill; for a spacing that is not positive or makes too many cells. Cancelled
ControlMesh fillSurface(const TriangleSurface& surface, const FillOptions& options,
                        FillReport* report = nullptr, const Context& context = {});

}  // namespace octet
