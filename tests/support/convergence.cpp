// SPDX-License-Identifier: Apache-2.0
#include "convergence.h"

#include <cmath>
#include <functional>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/forms/de_rham.h>

#include "meshes.h"
#include "test_data.h"
#include "voxels.h"

namespace octet::testing {
namespace {

constexpr int kDeeper = 3;
constexpr int kVoxels = 48;  // along the mesh' longest side
constexpr int kMargin = kVoxels / 6;
constexpr int kQuadrature = 8;

/// Turns about half around over the mesh' size, in each direction.
Vec3 smoothField(const Vec3& x) {
  return Vec3(std::sin(2.6 * x[1] + 0.4), std::cos(2 * x[2] + x[0]), std::sin(x[0] - 1.5 * x[1]));
}

/// The field over the unit ball or box that the mesh' bounds are mapped to, so that all meshes see
/// the same one.
template <int K>
Cochain<K> sampledForm(const ControlMesh& mesh, const Box& bounds, BoundaryMode mode) {
  const DeRham rham(*mesh.complex(), mesh.positions(), kQuadrature);
  const Vec3 centre = (bounds.min + bounds.max) / 2;
  const double radius = bounds.size().maxCoeff() / 2;
  const auto field = [&](const Vec3& x) { return smoothField((x - centre) / radius); };
  Cochain<K> form(*mesh.complex());
  if constexpr (K == 1) {
    form = rham.edges(field);
  } else {
    form = rham.facets(field);
  }
  if (mode == BoundaryMode::Open) return form;
  const Complex& c = *mesh.complex();
  for (Index f = 0; f < c.facetCount(); ++f) {
    if (c.facetCells[f][1].exists()) continue;
    if constexpr (K == 2) {
      form[f] = 0;
    } else {
      for (const EdgeRef& e : c.facetEdges[f]) form[e.index()] = 0;
    }
  }
  return form;
}

VoxelValues voxels(const VectorField& field, const GridFrame& frame) {
  return activeVoxels(
      [&](const auto& sink) { rasterize<3>(field.source(), frame, Sampling::Collocated, sink); });
}

/// Are there voxels kMargin away in all six directions?
bool isInside(const VoxelValues& values, const Ijk& ijk) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const int step : {-kMargin, kMargin}) {
      auto other = ijk;
      other[axis] += step;
      if (values.count(other) == 0) return false;
    }
  }
  return true;
}

/// Voxel values of one form, level after level.
struct Series {
  int degree;
  BoundaryMode mode;
  std::function<VoxelValues(const Refiner&, const Limit&, Reconstruction)> valuesOn;
  std::vector<VoxelValues> limit, whitney;
};

template <int K>
Series makeSeries(const ControlMesh& mesh, const Box& bounds, const GridFrame& frame,
                  BoundaryMode mode) {
  const Cochain<K> form = sampledForm<K>(mesh, bounds, mode);
  const auto valuesOn = [=](const Refiner& refiner, const Limit& limit, Reconstruction how) {
    return voxels(makeField<K>(refiner, limit, refiner.refine(form, mode), mode, how), frame);
  };
  return {K, mode, valuesOn, {}, {}};
}

VoxelError compare(const VoxelValues& values, const VoxelValues& reference) {
  double difference[2] = {}, size[2] = {};
  for (const auto& [ijk, value] : values) {
    const auto exact = reference.find(ijk);
    if (exact == reference.end()) continue;
    for (int k = 0; k < (isInside(reference, ijk) ? 2 : 1); ++k) {
      difference[k] += (value - exact->second).squaredNorm();
      size[k] += exact->second.squaredNorm();
    }
  }
  return {std::sqrt(difference[0] / size[0]), std::sqrt(difference[1] / size[1])};
}

}  // namespace

std::vector<ConvergenceMesh> convergenceMeshes() {
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 16; };
  return {{"lattice", ControlMesh::build(latticeBlock(ball, 4))},
          {"Gmsh ball", readControlAsset(testData("reference/ball.octet")).mesh},
          {"random ball", ControlMesh::build(randomBall(50, 3))},
          {"creased box", ControlMesh::build(creasedBox(3, 0.1, 4))}};
}

std::vector<Convergence> convergence(const ControlMesh& mesh, int levels) {
  Box bounds;
  for (const Vec3& x : mesh.positions()) bounds.extend(x);
  // Off the mesh' own planes.
  GridFrame frame;
  frame.voxelSize = bounds.size().maxCoeff() / kVoxels;
  frame.origin = bounds.min + frame.voxelSize * Vec3(0.31, 0.43, 0.57);

  std::vector<Series> series;
  for (const BoundaryMode mode : {BoundaryMode::Open, BoundaryMode::Walls}) {
    series.push_back(makeSeries<1>(mesh, bounds, frame, mode));
    series.push_back(makeSeries<2>(mesh, bounds, frame, mode));
  }
  for (int level = 0; level < levels + kDeeper; ++level) {
    RefinerOptions options;
    options.levels = level;
    const Refiner refiner(mesh, options);
    const Limit limit(refiner);
    for (Series& s : series) {
      s.limit.push_back(s.valuesOn(refiner, limit, Reconstruction::Limit));
      if (level < levels) {
        s.whitney.push_back(s.valuesOn(refiner, limit, Reconstruction::Whitney));
      }
    }
  }
  std::vector<Convergence> result;
  for (const Series& s : series) {
    Convergence c{s.degree, s.mode, {}, {}};
    for (int level = 0; level < levels; ++level) {
      const VoxelValues& reference = s.limit[level + kDeeper];
      c.limit.push_back(compare(s.limit[level], reference));
      c.whitney.push_back(compare(s.whitney[level], reference));
    }
    result.push_back(std::move(c));
  }
  return result;
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace octet::testing
