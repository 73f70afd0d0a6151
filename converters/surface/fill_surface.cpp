// SPDX-License-Identifier: Apache-2.0
#include "fill_surface.h"

#include <cmath>

#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>
#include <octet/core/cage/nesting.h>

#include "vdb_surface.h"

namespace octet {
namespace {

/// Voxels of the inside test per lattice edge.
constexpr double kVoxelsPerEdge = 4;
/// Distances are needed this far from the surface, in spacings.
constexpr double kBand = 2;

/// The layers of nested parts; all in one where parts that meet are one body.
std::vector<SurfaceLayer> layersOf(const TriangleSurface& surface, const FillOptions& options) {
  checkClosed(surface);
  const auto crossing = findSelfIntersection(surface);
  if (!crossing) return nestingLayers(surface);
  if (!options.allowIntersections) {
    throw InputError(
        "triangles[" + std::to_string(crossing->triangle) + "]",
        "the surface intersects itself: meets triangles[" + std::to_string(crossing->other) + "]");
  }
  return {{surface, std::abs(surface.volume()), 1}};
}

/// Bodies less cavities, and bodies in these again.
SignedDistance distanceTo(const std::vector<SurfaceLayer>& layers, double spacing) {
  std::vector<SignedDistance> distances;
  for (const SurfaceLayer& layer : layers) {
    distances.push_back(sampledDistance(layer.surface, spacing / kVoxelsPerEdge, kBand * spacing));
  }
  return [distances](const Vec3& p) {
    double d = distances[0](p);
    for (std::size_t k = 1; k < distances.size(); ++k) {
      const double inner = distances[k](p);
      d = k % 2 ? std::max(d, -inner) : std::min(d, inner);
    }
    return d;
  };
}

/// The same limit as in fillLattice, before OpenVDB is asked for a grid of that resolution.
void checkSpacing(const TriangleSurface& surface, double spacing) {
  if (surface.triangles.empty()) throw InputError("", "the surface has no triangles");
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

ControlMesh fillSurface(const TriangleSurface& surface, const FillOptions& options,
                        FillReport* report) {
  checkSpacing(surface, options.spacing);
  reportProgress(options.progress, {"find the inside", 0, 1, "surface"});
  const std::vector<SurfaceLayer> layers = layersOf(surface, options);
  FillReport done;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    done.bodyVolume += k % 2 ? -layers[k].volume : layers[k].volume;
    (k % 2 ? done.cavities : done.bodies) += layers[k].parts;
  }
  LatticeFillOptions lattice;
  lattice.spacing = options.spacing;
  lattice.depth = options.depth;
  lattice.progress = options.progress;
  ControlMeshInput input =
      fillLattice(surface.bounds(), distanceTo(layers, options.spacing), lattice, &done.lattice);
  ControlMesh mesh = ControlMesh::build(input);
  if (options.fitBoundary) {
    const ClosestPoints closest(surface);
    BoundaryFitOptions fit = options.fit;
    fit.progress = options.progress;
    input.vertices = fitBoundary(
        mesh, [&](const Vec3& p) { return closest.find(p).position; }, fit, &done.fit.emplace());
    mesh = ControlMesh::build(std::move(input));
  }
  if (report) *report = done;
  return mesh;
}

}  // namespace octet
