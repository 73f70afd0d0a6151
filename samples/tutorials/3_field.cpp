// SPDX-License-Identifier: Apache-2.0
// The limit of subdivision as a field: its value at any point, and a streamline through it.
// Argument: samples/box/box.octet.json
#include <cstdio>

#include <octet/converters/api.h>
#include <octet/core/api.h>

int main(int, char** argv) {
  const octet::ControlAsset asset = octet::readControlAsset(argv[1]);
  octet::RefinerOptions options;
  options.levels = 3;
  const octet::Refiner refiner(asset.mesh, options);
  const octet::Limit limit(refiner);
  const auto walls = octet::BoundaryMode::Walls;
  const auto flux = octet::coefficients<2>(asset, asset.form("velocity"));
  const octet::VectorField field =
      octet::makeField(refiner, limit, refiner.refine(flux, walls), walls);

  octet::Vec3 velocity;
  const bool inside = field.sample({0.5, 0.25, 0.1}, &velocity);
  std::printf("inside: %d, velocity %.3f %.3f %.3f\n", inside, velocity[0], velocity[1],
              velocity[2]);
  std::printf("inside: %d at a point beside the domain\n", field.sample({5, 0, 0}, &velocity));

  // Where the flow takes a particle, by the classical method of Runge and Kutta.
  octet::Vec3 p(0.5, 0.25, 0.1);
  const double step = 0.05;
  for (int k = 0; k < 200; ++k) {
    octet::Vec3 a, b, c, d;
    field.sample(p, &a);
    field.sample(p + step / 2 * a, &b);
    field.sample(p + step / 2 * b, &c);
    if (!field.sample(p + step * c, &d)) return 1;
    p += step / 6 * (a + 2 * b + 2 * c + d);
  }
  std::printf("after 10 s it is at %.2f %.2f %.2f\n", p[0], p[1], p[2]);
}
