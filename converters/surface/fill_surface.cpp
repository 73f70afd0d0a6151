// SPDX-License-Identifier: Apache-2.0
#include "fill_surface.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <octet/core/base/error.h>
#include <octet/core/cage/boundary_features.h>
#include <octet/core/cage/box_cage.h>
#include <octet/core/cage/nesting.h>
#include <octet/core/topology/overlap.h>

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
SignedDistance distanceTo(const std::vector<SurfaceLayer>& layers, double spacing,
                          const Context& context) {
  std::vector<SignedDistance> distances;
  for (const SurfaceLayer& layer : layers) {
    distances.push_back(
        sampledDistance(layer.surface, spacing / kVoxelsPerEdge, kBand * spacing, context));
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

/// @brief Fills and fits, and again without those interior vertices at which boundary vertices
/// could not reach the surface, or cells came to overlap: lattice vertices just deep enough,
/// mostly, below a crowd of others.
class Fitting {
 public:
  Fitting(const TriangleSurface& surface, const SignedDistance& distance,
          const LatticeFillOptions& lattice, const FillOptions& options, const Context& context)
      : surface_(surface),
        sharp_(findSharpEdges(surface, options.sharpAngle, kLeastSharp * options.spacing)),
        bounds_(surface.bounds()),
        closest_(surface),
        distance_(distance),
        lattice_(lattice),
        fit_(options.fit),
        context_(context) {}

  ControlMesh run(FillReport* report) {
    for (int attempt = 0;; ++attempt) {
      ControlMeshInput input =
          fillLattice(bounds_, distanceWithout(), lattice_, &report->lattice, context_.sub(0.1));
      const ControlMesh filled = ControlMesh::build(input, context_);
      input.vertices = fitBoundary(
          filled, filled.positions(),
          [&](const Vec3& p, Index) { return closest_.find(p).position; }, fit_,
          &report->fit.emplace(), context_.sub(0.2));
      std::vector<Index> around = report->fit->offSurface;
      const auto overlap = findOverlap(*filled.complex(), input.vertices, context_);
      if (overlap) {
        for (const Index cell : {overlap->cell, overlap->other}) {
          appendBoundary(*filled.complex(), cell, &around);
        }
      }
      const bool again = attempt < kAttempts && dropShallowest(filled, around);
      if (!again && overlap) {
        throw InputError("fit", "the surface is too narrow for this spacing: " +
                                    ControlMesh::cellName(*filled.complex(), overlap->cell) +
                                    " would overlap " +
                                    ControlMesh::cellName(*filled.complex(), overlap->other));
      }
      if (again) continue;
      followSharpEdges(filled, &input, report);
      return ControlMesh::build(std::move(input), context_);
    }
  }

 private:
  static constexpr int kAttempts = 6;
  /// Interior vertices this much deeper than the threshold, in spacings, are kept.
  static constexpr double kSpare = 0.5;
  static constexpr std::size_t kMostDropped = 1000;
  /// Vertices nearer to a sharp edge than this, in spacings, are on it.
  static constexpr double kOnEdge = 1e-9;

  // ---- sharp edges ------------------------------------------------------------------------------

  static double length(const std::array<Index, 2>& edge, const Array<Vec3>& x) {
    return (x[edge[1]] - x[edge[0]]).norm();
  }

  /// Moves chains of boundary vertices onto the sharp edges and marks as creases what gets there.
  /// Vertices that do not, or are in the way of others, are let go, and the rest is fitted again.
  void followSharpEdges(const ControlMesh& filled, ControlMeshInput* input, FillReport* report) {
    const Complex& c = *filled.complex();
    for (const auto& edge : sharp_.edges) report->sharpLength += length(edge, surface_.vertices);
    BoundaryFeatures features =
        findBoundaryFeatures(c, input->vertices, surface_, sharp_, lattice_.spacing);
    if (features.edges.empty()) return;
    const std::vector<TriangleSurface> chains = chainsAsSurfaces(surface_, sharp_);
    const std::vector<ClosestPoints> closestOnChain(chains.begin(), chains.end());
    const auto project = [&](const Vec3& p, Index v) -> Vec3 {
      if (v != kNone && features.corners[v] != kNone) return surface_.vertices[features.corners[v]];
      if (v != kNone && features.chains[v] != kNone) {
        return closestOnChain[features.chains[v]].find(p).position;
      }
      return closest_.find(p).position;
    };
    BoundaryFitReport fit;
    Array<Vec3> x;
    for (int attempt = 0;; ++attempt) {
      if (attempt == kAttempts || features.edges.empty()) return;
      x = fitBoundary(filled, input->vertices, project, fit_, &fit, context_.sub(0.1));
      std::vector<Index> bad = notThere(c, x, project, features);
      const bool worse = fit.offSurface.size() > report->fit->offSurface.size();
      if (worse) appendAround(c, fit.offSurface, &bad);
      if (bad.empty() && !worse) break;
      letGo(bad, &features);
    }
    if (findOverlap(c, x, context_)) return;
    fit.meanBefore = report->fit->meanBefore;
    fit.maxBefore = report->fit->maxBefore;
    report->fit = fit;
    input->vertices = std::move(x);
    for (const auto& edge : features.edges) report->creaseLength += length(edge, input->vertices);
    input->creases = features.edges;
    for (Index v = 0; v < c.vertexCount(); ++v) {
      if (features.corners[v] != kNone) input->corners.push_back(v);
    }
  }

  /// Vertices that are not on the corner or chain that they are to go to.
  std::vector<Index> notThere(const Complex& c, const Array<Vec3>& x,
                              const ProjectToSurface& project,
                              const BoundaryFeatures& features) const {
    std::vector<Index> result;
    for (Index v = 0; v < c.vertexCount(); ++v) {
      if (features.corners[v] == kNone && features.chains[v] == kNone) continue;
      if ((project(x[v], v) - x[v]).norm() > kOnEdge * lattice_.spacing) result.push_back(v);
    }
    return result;
  }

  /// Appends the vertices of all cells at some vertices.
  static void appendAround(const Complex& c, const std::vector<Index>& vertices,
                           std::vector<Index>* around) {
    for (const Index v : vertices) {
      c.visitVertexStar(v, [&](const CellAtVertex& at) { appendBoundary(c, at.cell, around); });
    }
  }

  /// Lets vertices go, with the edges at them.
  static void letGo(const std::vector<Index>& vertices, BoundaryFeatures* features) {
    for (const Index v : vertices) features->corners[v] = features->chains[v] = kNone;
    const auto isFree = [&](Index v) {
      return features->corners[v] == kNone && features->chains[v] == kNone;
    };
    auto& edges = features->edges;
    edges.erase(std::remove_if(edges.begin(), edges.end(),
                               [&](const auto& e) { return isFree(e[0]) || isFree(e[1]); }),
                edges.end());
  }

  /// The distance, but positive at lattice vertices that have been dropped.
  SignedDistance distanceWithout() const {
    return [this](const Vec3& p) {
      const double d = distance_(p);
      for (const Vec3& q : dropped_) {
        if ((p - q).norm() < lattice_.spacing / 4) return std::max(d, lattice_.spacing / 4);
      }
      return d;
    };
  }

  static void appendBoundary(const Complex& c, Index cell, std::vector<Index>* vertices) {
    for (int i = 0; i < c.cellVertexCount(cell); ++i) {
      if (c.vertexOnBoundary(c.cellVertex(cell, i))) vertices->push_back(c.cellVertex(cell, i));
    }
  }

  /// Drops the shallowest interior vertex around each of some boundary vertices; false when none is
  /// near enough to the threshold to be spared.
  bool dropShallowest(const ControlMesh& mesh, const std::vector<Index>& around) {
    const Complex& c = *mesh.complex();
    const std::size_t before = dropped_.size();
    for (const Index v : around) {
      std::optional<Vec3> shallowest;
      c.visitVertexStar(v, [&](const CellAtVertex& at) {
        for (int i = 0; i < c.cellVertexCount(at.cell); ++i) {
          const Index u = c.cellVertex(at.cell, i);
          if (c.vertexOnBoundary(u)) continue;
          const Vec3& p = mesh.positions()[u];
          if (!shallowest || distance_(p) > distance_(*shallowest)) shallowest = p;
        }
      });
      if (shallowest && -distance_(*shallowest) < (lattice_.depth + kSpare) * lattice_.spacing) {
        dropped_.push_back(*shallowest);
      }
    }
    return dropped_.size() > before && dropped_.size() <= kMostDropped;
  }

  const TriangleSurface& surface_;
  const SharpEdges sharp_;
  Box bounds_;
  ClosestPoints closest_;
  const SignedDistance& distance_;
  const LatticeFillOptions& lattice_;
  const BoundaryFitOptions& fit_;
  const Context& context_;
  std::vector<Vec3> dropped_;
};

}  // namespace

ControlMesh fillSurface(const TriangleSurface& surface, const FillOptions& options,
                        FillReport* report, const Context& context) {
  checkSpacing(surface, options.spacing);
  if (!(options.sharpAngle > 0 && options.sharpAngle <= 180)) {
    throw InputError("sharp-angle", "is not between 0 and 180");
  }
  context.report({"find the inside", 0, 1, "surface"});
  const std::vector<SurfaceLayer> layers = layersOf(surface, options);
  FillReport done;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    done.bodyVolume += k % 2 ? -layers[k].volume : layers[k].volume;
    (k % 2 ? done.cavities : done.bodies) += layers[k].parts;
  }
  LatticeFillOptions lattice;
  lattice.spacing = options.spacing;
  lattice.depth = options.depth;
  const SignedDistance distance = distanceTo(layers, options.spacing, context);
  ControlMesh mesh =
      options.fitBoundary
          ? Fitting(surface, distance, lattice, options, context).run(&done)
          : ControlMesh::build(
                fillLattice(surface.bounds(), distance, lattice, &done.lattice, context), context);
  if (report) *report = done;
  return mesh;
}

}  // namespace octet
