// SPDX-License-Identifier: Apache-2.0
#include "noise_waves.h"

#include <cmath>
#include <random>

#include "../base/numbers.h"

namespace octet {
namespace {

/// The same numbers with every standard library, unlike its distributions.
class Uniform {
 public:
  explicit Uniform(std::uint32_t seed) : engine_(seed) {}
  double operator()() { return (engine_() + 0.5) / 4294967296.0; }

 private:
  std::mt19937 engine_;
};

}  // namespace

NoiseWaves makeWaves(const CurlNoise& noise) {
  Uniform uniform(noise.seed);
  NoiseWaves waves;
  double meanSquare = 0;
  const double lowest = 2 * kPi / noise.longest, range = std::log(noise.longest / noise.shortest);
  for (int n = 0; n < noise.waves; ++n) {
    const double k = lowest * std::exp(range * (n + uniform()) / noise.waves);
    // A direction, and one at right angles to it.
    const double z = 2 * uniform() - 1, turn = 2 * kPi * uniform(), r = std::sqrt(1 - z * z);
    const Vec3 direction(r * std::cos(turn), r * std::sin(turn), z);
    const Vec3 side = direction.unitOrthogonal(), other = direction.cross(side);
    const double polarisation = 2 * kPi * uniform();
    // Waves are even in log k, where the energy's density is k E(k); velocity is k times potential.
    const double speed = std::pow(k / lowest, (1 - noise.exponent) / 2);
    const Vec3 amplitude =
        speed / k * (std::cos(polarisation) * side + std::sin(polarisation) * other);
    waves.push_back({k * direction, amplitude, 2 * kPi * uniform()});
    meanSquare += speed * speed / 2;
  }
  for (NoiseWave& wave : waves) wave.amplitude *= noise.speed / std::sqrt(meanSquare);
  return waves;
}

}  // namespace octet
