// SPDX-License-Identifier: Apache-2.0
// How near grids made of circulations come to the limit of refinement, beside samples, against
// three levels deeper; Markdown tables: conservation [LEVELS]
// Errors are relative to the largest speed, over voxels whose whole stencil lies inside.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <mutex>
#include <string>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/forms/de_rham.h>
#include <octet/core/geometry/domain_box.h>
#include <octet/core/geometry/mean_edge.h>
#include <octet/core/hodge/flux_rasterizer.h>

#include "tests/support/meshes.h"

namespace octet::bench {
namespace {

constexpr int kDeeper = 3;
constexpr int kQuadrature = 8;

using Ijk = std::array<std::int32_t, 3>;
using Values = std::map<Ijk, Vec3>;

/// The curl of a potential field, exactly: linear in each of its pieces.
class CurlSource : public PieceSource<3> {
 public:
  CurlSource(const PotentialField& field, std::shared_ptr<const Complex> complex)
      : PieceSource<3>(std::move(complex), field.positions()), field_(field) {}

  void visitPieces(Index cell, const Filter& wanted, const Sink& sink) const override {
    field_.visitPieces(cell, [&](const PotentialPiece& piece) {
      Piece<3> curl;
      curl.points = piece.points;
      if (!wanted(curl.box())) return;
      const Barycentric lambda(piece.points);
      if (!lambda.finite()) return;
      for (int corner = 0; corner < 4; ++corner) {
        curl.values[corner] = curlAt(piece, lambda.gradients, corner);
      }
      sink(curl);
    });
  }

 private:
  /// With W_ij = l_i g_j - l_j g_i: curl W_ij = 2 g_i x g_j, curl (l W) = g x W + l curl W.
  static Vec3 curlAt(const PotentialPiece& piece, const std::array<Vec3, 4>& g, int corner) {
    const auto l = [corner](int i) { return i == corner ? 1.0 : 0.0; };
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 6; ++k) {
      const int i = Tetrahedron::edges[k][0], j = Tetrahedron::edges[k][1];
      sum += 2 * piece.edges[k] * g[i].cross(g[j]);
    }
    for (int f = 0; f < 4; ++f) {
      const auto& t = Tetrahedron::facets[f];
      for (int k = 0; k < 3; ++k) {
        const int x = t[k], y = t[(k + 1) % 3], z = t[(k + 2) % 3];
        const Vec3 whitney = l(y) * g[z] - l(z) * g[y];
        sum += piece.facets[f][k] * (g[x].cross(whitney) + 2 * l(x) * g[y].cross(g[z]));
      }
    }
    return sum;
  }

  const PotentialField& field_;
};

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

/// Runs a rasteriser and keeps its active voxels.
template <typename Rasterize>
Values voxels(const Rasterize& rasterizeTo) {
  Values values;
  std::mutex mutex;
  rasterizeTo([&](const Tile<3>& tile) {
    const std::lock_guard<std::mutex> lock(mutex);
    for (int n = 0; n < Tile<3>::kSize; ++n) {
      if (!tile.isActive(n)) continue;
      values[{tile.origin[0] + n / 64, tile.origin[1] + n / 8 % 8, tile.origin[2] + n % 8}] =
          Vec3(tile.values[0][n], tile.values[1][n], tile.values[2][n]);
    }
  });
  return values;
}

Values samples(const PieceSource<3>& source, const GridFrame& frame, Sampling sampling) {
  return voxels([&](const auto& sink) { rasterize<3>(source, frame, sampling, sink); });
}

double largest(const Values& values) {
  double result = 0;
  for (const auto& [ijk, value] : values) result = std::max(result, value.norm());
  return result;
}

struct Error {
  double rms = 0, most = 0;
};

/// Over the voxels of `where`.
Error error(const Values& values, const Values& truth, const Values& where) {
  Error result;
  double sum = 0;
  std::size_t n = 0;
  for (const auto& [ijk, ignored] : where) {
    const auto value = values.find(ijk), exact = truth.find(ijk);
    if (value == values.end() || exact == truth.end()) continue;
    const double difference = (value->second - exact->second).norm();
    sum += difference * difference;
    result.most = std::max(result.most, difference);
    ++n;
  }
  const double scale = 100 / largest(truth);
  return {scale * std::sqrt(sum / static_cast<double>(std::max<std::size_t>(n, 1))),
          scale * result.most};
}

/// Voxels with active ones two away in all six directions.
Values inner(const Values& values) {
  Values result;
  for (const auto& [ijk, value] : values) {
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      for (const int step : {-2, 2}) {
        Ijk other = ijk;
        other[axis] += step;
        inside = inside && values.count(other) != 0;
      }
    }
    if (inside) result.emplace(ijk, value);
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

void printHeader(const char* title, const double* ratios, std::size_t count) {
  std::printf("%s\n| mesh | flow |", title);
  for (std::size_t k = 0; k < count; ++k) std::printf(" h/edge %.2g |", ratios[k]);
  std::printf("\n|---|---|");
  for (std::size_t k = 0; k < count; ++k) std::printf("---|");
  std::printf("\n");
}

void collocated(const char* mesh, const Flow& flow, const Level& level, const Level& deep) {
  const VectorField sampled = flow.limitOn(level), reference = flow.limitOn(deep);
  const PotentialField potential = flow.potentialOn(level);
  std::printf("| %s | %s |", mesh, flow.name);
  for (const double ratio : kCollocatedRatios) {
    const GridFrame frame = frameOf(level, ratio);
    const Values means = voxels([&](const auto& sink) {
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

/// A row of the second table.
std::string staggered(const char* mesh, const Flow& flow, const Level& level, const Level& deep) {
  const VectorField reference = flow.limitOn(deep);
  const PotentialField potential = flow.potentialOn(level);
  const CurlSource exact(potential, level.complex());
  std::string row = "| " + std::string(mesh) + " | " + flow.name + " |";
  for (const double ratio : kStaggeredRatios) {
    const GridFrame frame = frameOf(level, ratio);
    const Values fluxes =
        voxels([&](const auto& sink) { rasterizeFluxes(potential, frame, sink); });
    const Values ofLevel = samples(exact, frame, Sampling::Staggered);
    const Values truth = samples(reference.source(), frame, Sampling::Staggered);
    const Values where = inner(truth);
    char cell[64];
    std::snprintf(cell, sizeof cell, " %.2g, %.2g, %.2g |", error(fluxes, ofLevel, where).rms,
                  error(ofLevel, truth, where).rms, error(fluxes, truth, where).rms);
    row += cell;
  }
  return row + "\n";
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

void run(int levels) {
  std::printf("Level %d; errors in %% of the largest speed\n\n", levels);
  printHeader("Collocated: rms of samples/circulations, then the largest of both",
              kCollocatedRatios, std::size(kCollocatedRatios));
  std::string rows;
  for (const Mesh& m : meshes()) {
    const Level level(m.mesh, levels), deep(m.mesh, levels + kDeeper);
    for (const Flow& flow : flowsOn(m.mesh)) {
      collocated(m.name, flow, level, deep);
      rows += staggered(m.name, flow, level, deep);
    }
  }
  std::printf("\n");
  printHeader("Staggered: rms of the grid, of the level, of both together", kStaggeredRatios,
              std::size(kStaggeredRatios));
  std::printf("%s", rows.c_str());
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) try {
  int levels = 2;
  if (argc > 1) {
    const char* const end = argv[1] + std::strlen(argv[1]);
    const auto [last, status] = std::from_chars(argv[1], end, levels);
    if (status != std::errc() || last != end || levels < 0 || levels > 3) {
      std::fprintf(stderr, "usage: conservation [LEVELS], 0 to 3\n");
      return 2;
    }
  }
  octet::bench::run(levels);
} catch (const std::exception& error) {
  std::fprintf(stderr, "conservation: %s\n", error.what());
  return 1;
}
