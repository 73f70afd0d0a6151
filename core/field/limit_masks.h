// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/types.h"
#include "../rules/lattice.h"

namespace octet {

/// One term of a limit mask at a regular vertex: a simplex of its 1-ring and its weight.
struct MaskTerm {
  std::uint8_t simplexClass;
  /// Its vertices as neighbours of the centre (kSelf: the centre itself), the base first; up to
  /// three are given.
  std::array<std::uint8_t, 3> vertices;
  Vec3 weight;  ///< first component only, for degrees 0 and 3
};

/// @brief Exact limit masks at a regular vertex (SCHEME.md section 5): left eigenvectors of the
/// subdivision of its 1-ring, dual to constants. Applied to coefficients along the lattice classes
/// they give the limit value (degree 0), the limit vector in lattice coordinates (degree 1), the
/// limit flux density in them (degree 2) and the limit mass per lattice volume (degree 3).
struct LimitMasks {
  /// Derives the masks for a value of zeta from one refinement of the 1-ring.
  explicit LimitMasks(double zeta);

  /// Whether forms of the degree have a limit: no other eigenvalue is as large as that of
  /// constants.
  std::array<bool, 4> exists{};
  std::array<std::vector<MaskTerm>, 4> terms;
};

}  // namespace octet
