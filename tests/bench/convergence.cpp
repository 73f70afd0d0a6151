// SPDX-License-Identifier: Apache-2.0
// How fast voxel values converge as levels are added, against the limit reconstruction three levels
// deeper; a Markdown table: convergence [LEVELS]
#include "tests/support/convergence.h"

#include <charconv>
#include <cstdio>
#include <cstring>
#include <exception>

#include <octet/core/base/error.h>

namespace octet::bench {
namespace {

using testing::VoxelError;

/// Error of the last level and the order between the last two.
void print(const std::vector<VoxelError>& errors, double VoxelError::*part) {
  const double fine = errors.back().*part, coarse = errors[errors.size() - 2].*part;
  std::printf(" %.2g %%, %.2f |", 100 * fine, testing::order(coarse, fine));
}

void run(int levels) {
  std::printf(
      "Error of level %d and order between the last two levels, inside and over all voxels\n"
      "| mesh | degree | mode | limit | Whitney | limit, all | Whitney, all |\n"
      "|---|---|---|---|---|---|---|\n",
      levels - 1);
  for (const auto& [name, mesh] : testing::convergenceMeshes()) {
    for (const testing::Convergence& c : testing::convergence(mesh, levels)) {
      std::printf("| %s | %d | %s |", name, c.degree,
                  c.mode == BoundaryMode::Walls ? "walls" : "open");
      for (const auto part : {&VoxelError::inside, &VoxelError::all}) {
        print(c.limit, part);
        print(c.whitney, part);
      }
      std::printf("\n");
      std::fflush(stdout);
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
