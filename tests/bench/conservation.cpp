// SPDX-License-Identifier: Apache-2.0
// How near grids made of circulations come to the limit of refinement, three levels deeper; errors
// in % of the largest speed, as Markdown tables: conservation collocated|staggered [LEVELS]
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/topology/domain_box.h>
#include <octet/core/topology/mean_edge.h>

#include "tests/support/meshes.h"
#include "tests/support/voxels.h"

namespace octet::bench {
namespace {

constexpr int kDeeper = 3;
constexpr int kQuadrature = 8;

using testing::activeVoxels;
using testing::Ijk;
using Values = testing::VoxelValues;

/// Operators of a level, for all forms on it.
struct Level {
  Level(const ControlMesh& mesh, int levels) : refiner(mesh, optionsFor(levels)), limit(refiner) {}
  static RefinerOptions optionsFor(int levels) {
    RefinerOptions options;
    options.levels = levels;
    return options;
  }
  std::shared_ptr<const Complex> complex() const { return refiner.sharedComplex(refiner.levels()); }

  Refiner refiner;
  Limit limit;
};

/// A closed 2-form by its potential, which vanishes on the boundary if walls are closed.
struct Flow {
  const char* name;
  Cochain<1> potential;
  BoundaryMode mode;

  Cochain<2> on(const Level& level) const {
    return d(level.refiner.finest(), level.refiner.refine(potential, mode));
  }
  VectorField limitOn(const Level& level) const {
    return makeField<2>(level.refiner, level.limit, on(level), mode);
  }
  PotentialField potentialOn(const Level& level) const {
    return {level.complex(), level.refiner.positions(level.refiner.levels()),
            level.refiner.refine(potential, mode), level.limit.vectors(on(level), mode),
            mode == BoundaryMode::Walls};
  }
};

/// Turns about half around over the mesh' size, in each direction.
Vec3 smoothPotential(const Vec3& x) {
  return Vec3(std::sin(2.6 * x[1] + 0.4) * std::cos(1.5 * x[2]), std::cos(2 * x[2] + x[0]),
              std::sin(x[0] - 1.5 * x[1]));
}

std::vector<Flow> flowsOn(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  const Box box = domainBox(c, mesh.positions());
  const Vec3 centre = (box.min + box.max) / 2;
  const double radius = box.size().maxCoeff() / 2;
  const DeRham rham(c, mesh.positions(), kQuadrature);
  const auto values = testing::randomValues(c.edgeCount(), 7);
  const Cochain<1> random(Array<double>(values.begin(), values.end()));
  const Cochain<1> smooth = rham.edges(
      [&](const Vec3& x) { return Vec3(radius * smoothPotential((x - centre) / radius)); });
  const auto closed = [&](Cochain<1> potential) {
    for (Index e = 0; e < c.edgeCount(); ++e) {
      if (c.edgeOnBoundary(e)) potential[e] = 0;
    }
    return potential;
  };
  return {{"random, walls", closed(random), BoundaryMode::Walls},
          {"random, open", random, BoundaryMode::Open},
          {"smooth, walls", closed(smooth), BoundaryMode::Walls},
          {"smooth, open", smooth, BoundaryMode::Open}};
}

Values samples(const PieceSource<3>& source, const GridFrame& frame, Sampling sampling) {
  return activeVoxels([&](const auto& sink) { rasterize<3>(source, frame, sampling, sink); });
}

struct Error {
  double rms = 0, most = 0;
};

/// Over the voxels of `where`, relative to the largest speed there.
Error error(const Values& values, const Values& truth, const Values& where) {
  double sum = 0, most = 0, speed = 0;
  std::size_t n = 0;
  for (const auto& [ijk, ignored] : where) {
    const auto value = values.find(ijk), exact = truth.find(ijk);
    if (value == values.end() || exact == truth.end()) continue;
    const double difference = (value->second - exact->second).norm();
    sum += difference * difference;
    most = std::max(most, difference);
    speed = std::max(speed, exact->second.norm());
    ++n;
  }
  const double scale = speed > 0 ? 100 / speed : 0;
  return {scale * std::sqrt(sum / static_cast<double>(std::max<std::size_t>(n, 1))), scale * most};
}

/// Voxels in the middle of the domain: farther than kMiddle of its size from the centre in no
/// direction.
Values inMiddle(const Values& values, const Box& box, const GridFrame& frame) {
  constexpr double kMiddle = 0.3;
  const Vec3 centre = (box.min + box.max) / 2, reach = kMiddle * box.size();
  Values result;
  for (const auto& [ijk, value] : values) {
    const Vec3 place = frame.origin + frame.voxelSize * Vec3(ijk[0], ijk[1], ijk[2]);
    if (((place - centre).cwiseAbs() - reach).maxCoeff() <= 0) result.emplace(ijk, value);
  }
  return result;
}

GridFrame frameOf(const Level& level, double voxelsPerEdge) {
  const auto& x = level.limit.positions();
  const Box box = domainBox(level.refiner.finest(), x);
  // Off the mesh' own planes.
  return {(box.min + box.max) / 2 + Vec3(0.013, 0.021, 0.017),
          voxelsPerEdge * meanEdge(level.refiner.finest(), x)};
}

constexpr double kCollocatedRatios[] = {0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.85, 1.0};
constexpr double kStaggeredRatios[] = {2.0, 1.0, 0.5, 0.25};

template <std::size_t N>
void printHeader(const char* title, const double (&ratios)[N]) {
  std::printf("%s\n| mesh | flow |", title);
  for (const double ratio : ratios) std::printf(" h/edge %.2g |", ratio);
  std::printf("\n|---|---|");
  for (std::size_t k = 0; k < N; ++k) std::printf("---|");
  std::printf("\n");
}

/// Over voxels that circulations can be had for.
void collocated(const char* mesh, const Flow& flow, const Level& level, const Level& deep) {
  const VectorField sampled = flow.limitOn(level), reference = flow.limitOn(deep);
  const PotentialField potential = flow.potentialOn(level);
  std::printf("| %s | %s |", mesh, flow.name);
  for (const double ratio : kCollocatedRatios) {
    const GridFrame frame = frameOf(level, ratio);
    const Values means = activeVoxels([&](const auto& sink) {
      rasterizeMeanFluxes(potential, frame, neighbourWeight(ratio), sink);
    });
    const Values truth = samples(reference.source(), frame, Sampling::Collocated);
    const Error ours = error(means, truth, means);
    const Error theirs =
        error(samples(sampled.source(), frame, Sampling::Collocated), truth, means);
    std::printf(" %.2g/%.2g %.2g/%.2g |", theirs.rms, ours.rms, theirs.most, ours.most);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// In the middle, where no boundary is near; of the reference's own level, whose cells are small
/// beside voxels, and of the level.
void staggered(const char* mesh, const Flow& flow, const Level& level, const Level& deep) {
  const VectorField reference = flow.limitOn(deep);
  const PotentialField potential = flow.potentialOn(level), deepPotential = flow.potentialOn(deep);
  std::printf("| %s | %s |", mesh, flow.name);
  for (const double ratio : kStaggeredRatios) {
    const GridFrame frame = frameOf(level, ratio);
    const Values truth = samples(reference.source(), frame, Sampling::Staggered);
    const Values where = inMiddle(truth, reference.bounds(), frame);
    const auto errorOf = [&](const PotentialField& field) {
      const Values fluxes =
          activeVoxels([&](const auto& sink) { rasterizeFluxes(field, frame, sink); });
      return error(fluxes, truth, where).rms;
    };
    std::printf(" %.2g, %.2g |", errorOf(deepPotential), errorOf(potential));
  }
  std::printf("\n");
  std::fflush(stdout);
}

struct Mesh {
  const char* name;
  ControlMesh mesh;
};

std::vector<Mesh> meshes() {
  const auto ball = [](int x, int y, int z) { return x * x + y * y + z * z <= 6; };
  return {{"lattice", ControlMesh::build(testing::latticeBlock(ball, 4))},
          {"random ball", ControlMesh::build(testing::randomBall(40, 3))},
          {"mixed ball", ControlMesh::build(testing::withOctahedra(testing::randomBall(40, 23)))},
          {"box", ControlMesh::build(testing::creasedBox(2, 0.12, 4))}};
}

void run(bool ofCollocated, int levels) {
  if (ofCollocated) {
    printHeader("Root mean square of samples/circulations, then the largest of both",
                kCollocatedRatios);
  } else {
    printHeader("Root mean square of the grid alone, then of the grid and its level",
                kStaggeredRatios);
  }
  for (const Mesh& m : meshes()) {
    const Level level(m.mesh, levels), deep(m.mesh, levels + kDeeper);
    for (const Flow& flow : flowsOn(m.mesh)) {
      (ofCollocated ? collocated : staggered)(m.name, flow, level, deep);
    }
  }
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) try {
  const std::string table = argc > 1 ? argv[1] : "";
  int levels = 2;
  bool understood = argc <= 3 && (table == "collocated" || table == "staggered");
  if (argc == 3) {
    const char* const end = argv[2] + std::strlen(argv[2]);
    const auto [last, status] = std::from_chars(argv[2], end, levels);
    understood = understood && status == std::errc() && last == end && levels >= 0 && levels <= 3;
  }
  if (!understood) {
    std::fprintf(stderr, "usage: conservation collocated|staggered [LEVELS], 0 to 3\n");
    return 2;
  }
  octet::bench::run(table == "collocated", levels);
} catch (const std::exception& error) {
  std::fprintf(stderr, "conservation: %s\n", error.what());
  return 1;
}
