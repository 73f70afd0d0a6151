// SPDX-License-Identifier: Apache-2.0
// Tracer particles through a velocity grid, with OpenVDB's own velocity integrator:
//   advect GRID.vdb NAME STEPS STEP_LENGTH COUNT X0 Y0 Z0 X1 Y1 Z1 OUT
// COUNT particles start at random places in the box, the same in every run, and take STEPS steps of
// the classical Runge-Kutta method, in which the fastest moves by STEP_LENGTH voxels. Their places
// are written to OUT as 3 x COUNT little-endian floats, those at the start and those at the end.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>
#include <vector>

#include <openvdb/openvdb.h>
#include <openvdb/tools/VelocityFields.h>
#include <tbb/parallel_for.h>

namespace {

using Points = std::vector<openvdb::Vec3f>;

/// The same numbers with every standard library.
Points randomPoints(std::size_t count, const openvdb::Vec3d& low, const openvdb::Vec3d& high) {
  std::mt19937 engine(7);
  Points points(count);
  for (openvdb::Vec3f& p : points) {
    for (int k = 0; k < 3; ++k) {
      p[k] = static_cast<float>(low[k] + (high[k] - low[k]) * (engine() / 4294967296.0));
    }
  }
  return points;
}

template <bool Staggered>
void move(const openvdb::Vec3SGrid& grid, int steps, float dt, Points* points) {
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, points->size(), 256), [&](const auto& range) {
        // One for each task: it keeps an accessor.
        const openvdb::tools::VelocityIntegrator<openvdb::Vec3SGrid, Staggered> integrator(grid);
        for (std::size_t k = range.begin(); k != range.end(); ++k) {
          for (int step = 0; step < steps; ++step)
            integrator.template rungeKutta<4>(dt, (*points)[k]);
        }
      });
}

void write(std::ostream& out, const Points& points) {
  out.write(reinterpret_cast<const char*>(points.data()),
            static_cast<std::streamsize>(points.size() * sizeof(openvdb::Vec3f)));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 13) {
    std::cerr << "usage: advect GRID.vdb NAME STEPS STEP_LENGTH COUNT X0 Y0 Z0 X1 Y1 Z1 OUT\n";
    return 2;
  }
  const auto number = [&](int k) { return std::atof(argv[k]); };
  openvdb::initialize();
  openvdb::io::File file(argv[1]);
  file.open(/*delayLoad=*/false);
  const auto grid = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid(argv[2]));
  if (!grid) {
    std::cerr << "advect: " << argv[2] << " is no vec3s grid\n";
    return 2;
  }
  float fastest = 0;
  for (auto it = grid->cbeginValueOn(); it; ++it) fastest = std::max(fastest, it->length());
  const float dt = static_cast<float>(number(4) * grid->voxelSize()[0]) / fastest;

  const Points start =
      randomPoints(static_cast<std::size_t>(number(5)), {number(6), number(7), number(8)},
                   {number(9), number(10), number(11)});
  Points end = start;
  if (grid->getGridClass() == openvdb::GRID_STAGGERED) {
    move<true>(*grid, std::atoi(argv[3]), dt, &end);
  } else {
    move<false>(*grid, std::atoi(argv[3]), dt, &end);
  }
  std::ofstream out(argv[12], std::ios::binary);
  write(out, start);
  write(out, end);
  return out.flush() ? 0 : 1;
}
