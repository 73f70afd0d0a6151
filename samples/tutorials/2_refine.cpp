// SPDX-License-Identifier: Apache-2.0
// Subdivision: levels of a cage, and that refinement commutes with the derivative, so that what has
// no divergence on the cage has none on any level. Argument: samples/box/box.octet.json
#include <cstdio>

#include <octet/converters/api.h>
#include <octet/core/api.h>

int main(int, char** argv) {
  const octet::ControlAsset asset = octet::readControlAsset(argv[1]);
  octet::RefinerOptions options;
  options.levels = 3;
  const octet::Refiner refiner(asset.mesh, options);
  for (int level = 0; level <= refiner.levels(); ++level) {
    std::printf("level %d: %d cells\n", level, refiner.complex(level).cellCount());
  }

  // A form is refined with the operators of all levels, which are built once.
  const auto walls = octet::BoundaryMode::Walls;
  const auto potential = octet::coefficients<1>(asset, asset.form("potential"));
  const octet::Cochain<2> one = octet::d(refiner.finest(), refiner.refine(potential, walls));
  const octet::Cochain<2> other = refiner.refine(octet::d(refiner.complex(0), potential), walls);
  double largest = 0;
  for (octet::Index f = 0; f < one.size(); ++f) {
    largest = std::max(largest, std::abs(one[f] - other[f]));
  }
  std::printf("d S and S d differ by less than 1e-15: %s\n", largest < 1e-15 ? "yes" : "no");
}
