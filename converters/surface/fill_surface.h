// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/cage/lattice_fill.h>
#include <octet/core/cage/triangle_surface.h>

namespace octet {

struct FillOptions {
  double spacing = 0;  ///< edge length of the lattice, world units
  /// Interior vertices lie deeper than this, in spacings (lattice_fill.h).
  double depth = 0.5;
  /// Take a surface that passes through itself for the body it encloses, instead of refusing it.
  bool allowIntersections = false;
  ProgressCallback progress;
};

struct FillReport {
  LatticeFillReport lattice;
  double bodyVolume = 0;  ///< of the surface
};

/// @brief A control mesh that fills a closed surface with the regular lattice (lattice_fill.h),
/// inside and outside told by OpenVDB's meshToVolume.
/// @throws InputError for a surface that is not closed, intersects itself or is thinner everywhere
/// than the lattice can fill; for a spacing that is not positive or makes too many cells.
ControlMeshInput fillSurface(const TriangleSurface& surface, const FillOptions& options,
                             FillReport* report = nullptr);

}  // namespace octet
