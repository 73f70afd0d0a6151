// SPDX-License-Identifier: Apache-2.0
#include "grid_choice.h"

#include <cmath>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>
#include <octet/core/topology/domain_box.h>
#include <octet/core/topology/mean_edge.h>

namespace octet {
namespace {

/// Automatic levels refine until the mean fine edge is at most this many voxels.
constexpr double kVoxelsPerEdge = 2;
/// What a cell of the finest level takes in memory, at most (tests/bench/memory.cpp).
constexpr double kBytesPerCell = 600;

/// The machine's memory in bytes. Beyond it the system would end the program, or others.
double machineMemory() {
  const std::uint64_t bytes = system::physicalMemory();
  return bytes > 0 ? static_cast<double>(bytes) : HUGE_VAL;
}

/// A mesh after one level: what its limit surface and the levels after it are foreseen from.
struct OneLevel {
  double longestSide, edge, cells;

  OneLevel(const ControlMesh& mesh, double zeta) {
    RefinerOptions options;
    options.levels = 1;
    options.zeta = zeta;
    const Refiner refiner(mesh, options);
    const Limit limit(refiner);
    longestSide = domainBox(refiner.finest(), limit.positions()).size().maxCoeff();
    edge = meanEdge(refiner.finest(), limit.positions());
    cells = static_cast<double>(refiner.finest().cellCount());
  }
};

double chooseVoxelSize(const OneLevel& one, const BakeOptions& options) {
  const bool bySize = options.voxelSize != 0, byCount = options.resolution != 0;
  if (bySize == byCount) {
    throw InputError("voxel size", bySize ? "is given twice, also as a resolution"
                                          : "is missing: give it or a resolution");
  }
  if (bySize) {
    if (!(options.voxelSize > 0) || !std::isfinite(options.voxelSize)) {
      throw InputError("voxel size", "is not a positive number");
    }
    return options.voxelSize;
  }
  if (options.resolution < 1) throw InputError("resolution", "is less than 1");
  return one.longestSide / options.resolution;
}

int automaticLevels(const ControlMesh& mesh, const OneLevel& one, double voxelSize) {
  int levels = 0;
  double edge = meanEdge(*mesh.complex(), mesh.positions());
  while (edge > kVoxelsPerEdge * voxelSize) {
    edge = levels == 0 ? one.edge : edge / 2;
    ++levels;
  }
  return levels;
}

void checkMemory(const OneLevel& one, int levels) {
  // A level halves edges and makes eight times the cells, about.
  const double cells = one.cells * std::pow(8.0, levels - 1);
  const double needed = kBytesPerCell * cells, there = machineMemory();
  if (needed <= there) return;
  const auto inUnits = [](double x, double unit) {
    return std::to_string(static_cast<std::int64_t>(std::llround(x / unit)));
  };
  throw InputError("levels", std::to_string(levels) + " would make about " + inUnits(cells, 1e6) +
                                 " million cells, which need up to " + inUnits(needed, 1e9) +
                                 " GB of memory; this machine has " + inUnits(there, 1e9) +
                                 " GB; give fewer --levels or larger voxels");
}

}  // namespace

GridChoice chooseGrid(const ControlMesh& mesh, const BakeOptions& options) {
  const OneLevel one(mesh, options.zeta);
  GridChoice choice;
  choice.voxelSize = chooseVoxelSize(one, options);
  choice.levels = options.levels ? *options.levels : automaticLevels(mesh, one, choice.voxelSize);
  checkMemory(one, choice.levels);
  return choice;
}

}  // namespace octet
