// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "refiner.h"

namespace octet {

/// A level with the operators that lead to it from the one before.
struct Refiner::Level {
  std::shared_ptr<const Complex> complex;
  Array<Vec3> positions;
  Boundary boundary;
  LatticeSites sites;
  std::unique_ptr<Smoothing> smoothing;
  std::unique_ptr<PatchTest> patchTest;
};

}  // namespace octet
