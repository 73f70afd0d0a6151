// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "../base/context.h"
#include "../topology/control_mesh.h"

namespace octet {

/// The point of a surface nearest to a point. Where the point is a boundary vertex that is to lie
/// on a curve or corner of the surface, the nearest there; any other point comes with kNone. Called
/// from many threads.
using ProjectToSurface = std::function<Vec3(const Vec3&, Index vertex)>;

struct BoundaryFitOptions {
  /// Corners of cells (cell_shape.h) keep at least this part of the volume they had on average.
  double minVolume = 0.05;
  int rounds = 24;         ///< sweeps over the boundary and the layers below it
  int interiorLayers = 2;  ///< layers of interior vertices that may move
};

/// Distances of boundary vertices and of the boundary facets' centroids from the surface.
struct BoundaryFitReport {
  double meanBefore = 0, maxBefore = 0;
  double meanAfter = 0, maxAfter = 0;
  double meanFacet = 0, maxFacet = 0;  ///< after; what flat facets leave of a curved surface
  std::vector<Index> offSurface;       ///< vertices left farther than a thousandth of the mean edge
  double minVolume = 0;                ///< least volume of a corner, relative to the average before
};

/// @brief Moves boundary vertices onto a surface, without inverting a cell.
///
/// Sweep by sweep each boundary vertex goes as far towards its nearest surface point as its cells
/// allow, then slides along the surface, and the layers below it move, to where the cells are least
/// distorted. Deeper vertices stay, so the interior of a lattice stays the lattice. A vertex that
/// cannot reach the surface is left on its way, and counted in the report.
/// The result does not depend on the number of threads.
/// @param start  positions to begin with; those of `mesh` tell what volumes were before
/// @return positions for the mesh' vertices. Cells stay positively oriented with at least the
/// stated volume; that far parts of the boundary do not meet is for ControlMesh::build to tell.
/// @throws Cancelled; InputError for a rounds or volume option out of range
Array<Vec3> fitBoundary(const ControlMesh& mesh, Array<Vec3> start, const ProjectToSurface& project,
                        const BoundaryFitOptions& options, BoundaryFitReport* report = nullptr,
                        const Context& context = {});

}  // namespace octet
