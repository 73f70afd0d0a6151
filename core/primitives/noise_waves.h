// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "primitive.h"

namespace octet {

/// One wave of a vector potential: amplitude cos(wave . x + phase), amplitude at right angles to
/// wave.
struct NoiseWave {
  Vec3 wave, amplitude;
  double phase;
};

/// The waves of a curl noise, from its seed.
using NoiseWaves = std::vector<NoiseWave>;
NoiseWaves makeWaves(const CurlNoise& noise);

}  // namespace octet
