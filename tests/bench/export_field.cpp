// SPDX-License-Identifier: Apache-2.0
// A refined vector field as tetrahedra, with its samples on a grid, for comparison with another
// program: export_field FOLDER [MESH] [SIZE]
// Files (numbers raw, in the machine's byte order; grid samples x fastest):
//   points.f64, vectors.f64, tetrahedra.i32   limit positions, limit vectors, vertex indices
//   samples.f64, inside.u8                    our samples, and which lie in the field
//   grid.json                                 the grid's frame, what was sampled, our rates
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>

#include <tbb/global_control.h>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#include <octet/core/field/vertex_field.h>
#include <octet/core/forms/de_rham.h>

#include "bench_meshes.h"

namespace octet::bench {
namespace {

constexpr int kRepetitions = 15;
constexpr std::size_t kGridSize = std::size_t{kResolution} * kResolution * kResolution;

/// Tetrahedra of a field, octahedra cut up as VertexField does.
struct TetMesh {
  explicit TetMesh(const VertexField<3>& field)
      : points(field.positions()), vectors(field.values()) {
    const Complex& c = field.complex();
    tets.assign(c.tets.begin(), c.tets.end());
    for (const auto& oct : c.octs) {
      const Index centre = static_cast<Index>(points.size());
      Vec3 position = Vec3::Zero(), vector = Vec3::Zero();
      for (const Index v : oct) {
        position += points[v] / 6;
        vector += vectors[v] / 6;
      }
      points.push_back(position);
      vectors.push_back(vector);
      for (const auto& f : Octahedron::facets) {
        tets.push_back({oct[f[0]], oct[f[1]], oct[f[2]], centre});
      }
    }
  }

  Array<Vec3> points, vectors;
  Array<std::array<Index, 4>> tets;
};

struct Samples {
  Array<Vec3> values;
  Array<std::uint8_t> inside;
};

/// Copies a tile's active samples; the frame's grid ends at kResolution.
void store(const Tile<3>& tile, Samples* samples) {
  for (int n = 0; n < Tile<3>::kSize; ++n) {
    if (!tile.isActive(n)) continue;
    const int x = tile.origin[0] + n / 64, y = tile.origin[1] + n / 8 % 8,
              z = tile.origin[2] + n % 8;
    const std::size_t at = (static_cast<std::size_t>(z) * kResolution + y) * kResolution + x;
    samples->values[at] = Vec3(tile.values[0][n], tile.values[1][n], tile.values[2][n]);
    samples->inside[at] = 1;
  }
}

/// Median seconds that sampling takes; the samples are written into a dense array, as part of the
/// work.
struct Seconds {
  double processor = 0;  ///< of all threads; on one it does not depend on what else runs
  double wall = 0;
};
Seconds sample(const VectorField& field, const GridFrame& frame, int threads, Samples* samples) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  std::vector<double> processor, wall;
  for (int k = 0; k < kRepetitions; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t ticks = std::clock();
    samples->values.assign(kGridSize, Vec3::Zero());
    samples->inside.assign(kGridSize, 0);
    rasterize<3>(field.source(), frame, Sampling::Collocated,
                 [&](const Tile<3>& tile) { store(tile, samples); });
    processor.push_back(static_cast<double>(std::clock() - ticks) / CLOCKS_PER_SEC);
    wall.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  const auto median = [](std::vector<double>* times) {
    std::nth_element(times->begin(), times->begin() + kRepetitions / 2, times->end());
    return (*times)[kRepetitions / 2];
  };
  return {median(&processor), median(&wall)};
}

/// A smooth flow, sampled on the control mesh.
Cochain<2> smoothForm(const ControlMesh& mesh) {
  const DeRham rham(*mesh.complex(), mesh.positions(), 6);
  return rham.facets([](const Vec3& x) {
    return Vec3(std::sin(2 * x[1] + 0.4), std::cos(2 * x[2] + x[0]), std::sin(x[0] - 1.5 * x[1]));
  });
}

template <typename T>
void write(const std::string& path, const Array<T>& data) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(data.data()),
             static_cast<std::streamsize>(data.size() * sizeof(T)));
  if (!file.flush()) throw IoError(path, "cannot be written");
}

void run(const std::string& folder, const std::string& name, const std::string& sizeName) {
  const ControlMesh mesh = controlMesh(name);
  const Refiner refiner = makeRefiner(mesh, findSize(sizeName).levels);
  const Limit limit(refiner);
  const auto mode = BoundaryMode::Open;
  const VectorField field =
      makeField<2>(refiner, limit, refiner.refine(smoothForm(mesh), mode), mode);
  const GridFrame frame = frameOver(field.bounds());
  Samples samples;
  const Seconds seconds = sample(field, frame, 1, &samples);

  const TetMesh tets(dynamic_cast<const VertexField<3>&>(field.source()));
  write(folder + "/points.f64", tets.points);
  write(folder + "/vectors.f64", tets.vectors);
  write(folder + "/tetrahedra.i32", tets.tets);
  write(folder + "/samples.f64", samples.values);
  write(folder + "/inside.u8", samples.inside);
  std::ofstream file(folder + "/grid.json");
  file.precision(17);
  file << "{\"mesh\": \"" << name << "\", \"cells\": " << refiner.finest().cellCount()
       << ", \"resolution\": " << kResolution << ", \"origin\": [" << frame.origin[0] << ", "
       << frame.origin[1] << ", " << frame.origin[2] << "], \"spacing\": " << frame.voxelSize
       << ", \"seconds\": " << seconds.processor << ", \"wall_seconds\": " << seconds.wall << "}\n";
  if (!file.flush()) throw IoError(folder + "/grid.json", "cannot be written");
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) try {
  if (argc < 2) {
    std::fprintf(stderr, "usage: export_field FOLDER [MESH] [SIZE]\n");
    return 2;
  }
  octet::bench::run(argv[1], argc > 2 ? argv[2] : "ball", argc > 3 ? argv[3] : "50k");
} catch (const std::exception& error) {
  std::fprintf(stderr, "export_field: %s\n", error.what());
  return 1;
}
