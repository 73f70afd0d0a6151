// SPDX-License-Identifier: Apache-2.0
// How fast voxel values converge as levels are added, against the limit reconstruction three levels
// deeper; a Markdown table: convergence [LEVELS]
#include "tests/support/convergence.h"

#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>

#include <octet/core/base/error.h>

#include "tests/support/meshes.h"

namespace octet::bench {
namespace {

using testing::VoxelError;

void print(const char* reconstruction, const std::vector<VoxelError>& errors) {
  std::printf(" %s |", reconstruction);
  for (const VoxelError& e : errors) std::printf(" %.1e |", e.inside);
  const VoxelError &fine = errors.back(), &coarse = errors[errors.size() - 2];
  std::printf(" %.2f | %.1e | %.2f |\n", testing::order(coarse.inside, fine.inside), fine.all,
              testing::order(coarse.all, fine.all));
  std::fflush(stdout);
}

template <int K>
void rows(const char* name, const ControlMesh& mesh, BoundaryMode mode, int levels) {
  const testing::Convergence errors = testing::convergence<K>(mesh, mode, levels);
  for (const bool limit : {true, false}) {
    std::printf("| %s | %d | %s |", name, K, mode == BoundaryMode::Walls ? "walls" : "open");
    print(limit ? "limit" : "Whitney", limit ? errors.limit : errors.whitney);
  }
}

void run(int levels) {
  std::printf("| mesh | degree | mode | reconstruction |");
  for (int k = 0; k < levels; ++k) std::printf(" level %d |", k);
  std::printf(" order | at the boundary too | order |\n|---|---|---|---|");
  for (int k = 0; k < levels + 3; ++k) std::printf("---|");
  std::printf("\n");
  for (const auto& [name, input] : testing::convergenceMeshes()) {
    const ControlMesh mesh = ControlMesh::build(input);
    for (const auto mode : {BoundaryMode::Open, BoundaryMode::Walls}) {
      rows<1>(name.c_str(), mesh, mode, levels);
      rows<2>(name.c_str(), mesh, mode, levels);
    }
  }
}

}  // namespace
}  // namespace octet::bench

int main(int argc, char** argv) try {
  int levels = 3;
  if (argc > 1) {
    const char* const end = argv[1] + std::strlen(argv[1]);
    const auto [last, status] = std::from_chars(argv[1], end, levels);
    if (status != std::errc() || last != end || levels < 2 || levels > 4) {
      std::fprintf(stderr, "usage: convergence [LEVELS], 2 to 4\n");
      return 2;
    }
  }
  octet::bench::run(levels);
} catch (const std::exception& error) {
  std::fprintf(stderr, "convergence: %s\n", error.what());
  return 1;
}
