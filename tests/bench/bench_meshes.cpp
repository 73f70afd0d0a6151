// SPDX-License-Identifier: Apache-2.0
#include "bench_meshes.h"

#include <cmath>

#include <octet/core/base/error.h>

namespace octet::bench {

ControlMesh controlMesh(const std::string& name) {
  if (name == "box") return ControlMesh::build(testing::creasedBox(7, 0.1, 1));
  if (name == "lattice") {
    const auto inside = [](int x, int y, int z) { return x * x + y * y + z * z <= 36; };
    return ControlMesh::build(testing::latticeBlock(inside, 6, 0.1, 2));
  }
  if (name == "ball") return ControlMesh::build(testing::randomBall(300, 9));
  throw InputError("mesh", "\"" + name + "\" is not known");
}

Size findSize(const std::string& name) {
  for (const Size& size : kSizes) {
    if (name == size.name) return size;
  }
  throw InputError("size", "\"" + name + "\" is not known");
}

Refiner makeRefiner(const ControlMesh& mesh, int levels) {
  RefinerOptions options;
  options.levels = levels;
  return Refiner(mesh, options);
}

GridFrame frameOver(const Box& box) {
  // The spacing is a multiple of 2^-16 of its order of magnitude, the origin one of the spacing's
  // last digit.
  const double exact = box.size().maxCoeff() / (kResolution - 1.5);
  const double digit = std::ldexp(1.0, std::ilogb(exact) - 16);
  GridFrame frame;
  frame.voxelSize = std::ceil(exact / digit) * digit;
  for (int k = 0; k < 3; ++k) frame.origin[k] = std::floor(box.min[k] / digit) * digit;
  return frame;
}

}  // namespace octet::bench
