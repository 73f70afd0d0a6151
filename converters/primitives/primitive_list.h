// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <octet/core/primitives/primitive.h>

namespace octet {

/// @brief Reads primitives from a JSON document:
/// `{"primitives": [{"type": "uniform", "velocity": [1, 0, 0]}, ...]}`.
///
/// | type        | keys (those with a default may be left out)                              |
/// |-------------|--------------------------------------------------------------------------|
/// | uniform     | velocity                                                                 |
/// | rotation    | centre [0,0,0], angular_velocity                                         |
/// | vortex_line | point, direction, circulation, core 0                                    |
/// | vortex_ring | centre, normal, radius, circulation, core 0                              |
/// | source      | point, strength, core 0                                                  |
/// | curl_noise  | speed, longest, shortest, exponent 5/3, seed 0, waves 64                 |
/// @throws InputError with the file, the place ("primitives[2].radius") and the reason.
std::vector<Primitive> readPrimitives(const std::string& path);

}  // namespace octet
