// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "../base/types.h"

namespace octet {

/// How well one guide is followed. Errors are |v - wanted| / |wanted|, root mean square over the
/// guide's length.
struct GuideReport {
  std::string name;
  std::size_t samples = 0;
  double residual = 0;  ///< relative, 0.01 is one percent
  double worst = 0;     ///< at one sample, relative to the guide's own mean speed
};

/// Two guides that ask for different things in nearly the same place, and neither is followed
/// there.
struct GuideConflict {
  std::string first, second;  ///< names; the same for a curve that crosses itself
  Vec3 point;                 ///< where they disagree most
  double disagreement = 0;    ///< |wanted - wanted| / the greater of both
  double residual = 0;        ///< the greater of both, there
};

/// What a fit says of itself: how well guides are followed, how it was solved, what holds of walls.
struct FitReport {
  std::vector<GuideReport> guides;  ///< curves, then vectors
  double residual = 0;              ///< of all guides, relative, root mean square by weight
  std::vector<GuideConflict> conflicts;
  std::vector<std::string> remarks;  ///< what the user should know: little data, ill-posed, ...
  std::size_t equations = 0;
  Index unknowns = 0;
  bool direct = true;  ///< solved by factorisation
  int iterations = 0;
  double solverResidual = 0;
  /// Largest |flux| through a closed wall facet, relative to the largest flux: 0 for 2-forms; for a
  /// curl-free field the normal part of the limit field on the walls, relative to its size there.
  double wallFlux = 0;
  double divergence = 0;  ///< largest |d v| of a cell relative to the largest |v|, for 2-forms
};

}  // namespace octet
