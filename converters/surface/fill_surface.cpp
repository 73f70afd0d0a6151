// SPDX-License-Identifier: Apache-2.0
#include "fill_surface.h"

#include <cmath>

#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>

#include "vdb_surface.h"

namespace octet {
namespace {

/// Voxels of the inside test per lattice edge.
constexpr double kVoxelsPerEdge = 4;

void checkSurface(const TriangleSurface& surface, const FillOptions& options) {
  checkClosed(surface);
  if (options.allowIntersections) return;
  if (const auto crossing = findSelfIntersection(surface)) {
    throw InputError(
        "triangles[" + std::to_string(crossing->triangle) + "]",
        "the surface intersects itself: meets triangles[" + std::to_string(crossing->other) + "]");
  }
}

/// The same limit as in fillLattice, before OpenVDB is asked for a grid of that resolution.
void checkSpacing(const TriangleSurface& surface, double spacing) {
  if (!(spacing > 0) || !std::isfinite(spacing)) {
    throw InputError("spacing", "is not a positive number");
  }
  double cells = 3 / std::sqrt(2.0);
  const Vec3 size = surface.bounds().size();
  for (int k = 0; k < 3; ++k) cells *= size[k] / spacing + 1;
  if (!(cells < static_cast<double>(kMostCageCells))) {
    throw InputError("spacing",
                     "is too fine: the body's box has some " +
                         std::to_string(static_cast<std::int64_t>(std::min(cells, 9e18))) +
                         " cells of that size");
  }
}

}  // namespace

ControlMeshInput fillSurface(const TriangleSurface& surface, const FillOptions& options,
                             FillReport* report) {
  checkSurface(surface, options);
  checkSpacing(surface, options.spacing);
  reportProgress(options.progress, {"find the inside", 0, 1, "surface"});
  const SignedDistance distance =
      sampledDistance(surface, options.spacing / kVoxelsPerEdge, 2 * options.spacing);
  LatticeFillOptions lattice;
  lattice.spacing = options.spacing;
  lattice.depth = options.depth;
  lattice.progress = options.progress;
  FillReport done;
  ControlMeshInput mesh = fillLattice(surface.bounds(), distance, lattice, &done.lattice);
  done.bodyVolume = std::abs(surface.volume());
  if (report) *report = done;
  return mesh;
}

}  // namespace octet
