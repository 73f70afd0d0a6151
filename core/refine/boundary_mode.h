// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace octet {

/// How forms are refined at the boundary (SCHEME.md section 8).
enum class BoundaryMode : std::uint8_t {
  Walls,  ///< boundary simplices use boundary simplices only: zero wall flux stays exactly zero
  Open,   ///< constants are exact everywhere, flux through a curved wall is not kept at zero
};

/// The rows of D1 and D2 at the boundary.
enum class BoundaryRows : std::uint8_t {
  Smooth,  ///< on the boundary surface, which is Loop's with a rule of its own at irregular
           ///< vertices from the second split on, and in the stars beside it (SCHEME.md section 8b)
  Loop,    ///< on the boundary surface, which is exactly Loop's (SCHEME.md section 8)
  Star,    ///< means over the cells there are, as inside (the thesis' original rule, Fig. 5.5):
           ///< what is missing outside pulls the boundary in
};

}  // namespace octet
