// SPDX-License-Identifier: Apache-2.0
// Voxel values converge to those of three levels deeper: with the limit reconstruction at second
// order where the mesh is regular, and nearer than with Whitney forms everywhere. Between the first
// two levels, which is as far as a test can go; tests/bench/convergence goes on.
#include "tests/support/convergence.h"

#include <gtest/gtest.h>

namespace octet {
namespace {

using testing::Convergence;
using testing::order;
using testing::VoxelError;

std::vector<Convergence> convergenceOn(const std::string& name) {
  for (const auto& [meshName, mesh] : testing::convergenceMeshes()) {
    if (name == meshName) return testing::convergence(mesh, 2);
  }
  return {};
}

double lastOrder(const std::vector<VoxelError>& errors, double VoxelError::*part) {
  return order(errors[0].*part, errors[1].*part);
}

TEST(Convergence, IsOfSecondOrderOnTheLattice) {
  const auto all = convergenceOn("lattice");
  ASSERT_EQ(all.size(), 4u);
  for (const Convergence& c : all) {
    SCOPED_TRACE(c.degree);
    EXPECT_GT(lastOrder(c.limit, &VoxelError::inside), 1.9);
    EXPECT_GT(lastOrder(c.whitney, &VoxelError::inside), 0.9);
    EXPECT_LT(c.limit[1].inside, c.whitney[1].inside / 2);
  }
}

/// Around extraordinary simplices limit vectors are fitted, at first order.
void expectConvergence(const std::string& mesh, double orderOfLimit, double orderOfWhitney) {
  const auto all = convergenceOn(mesh);
  ASSERT_EQ(all.size(), 4u);
  for (const Convergence& c : all) {
    SCOPED_TRACE(std::to_string(c.degree) + (c.mode == BoundaryMode::Walls ? " walls" : " open"));
    EXPECT_GT(lastOrder(c.limit, &VoxelError::all), orderOfLimit);
    EXPECT_GT(lastOrder(c.whitney, &VoxelError::all), orderOfWhitney);
    EXPECT_LT(c.limit[1].all, c.whitney[1].all);
  }
}

TEST(Convergence, OnAnIrregularBallInBothModes) { expectConvergence("Gmsh ball", 0.9, 0.6); }

TEST(Convergence, OnACreasedBoxInBothModes) { expectConvergence("creased box", 1.4, 0.8); }

}  // namespace
}  // namespace octet
