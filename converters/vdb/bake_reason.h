// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/hodge/velocity_planner.h>

namespace octet {

/// How the values of a vector grid are made.
enum class GridMethod : std::uint8_t {
  None,          ///< of a scalar grid, or one that was read
  Samples,       ///< samples of the field
  Circulations,  ///< circulations of a vector potential: no discrete divergence
  Differences,   ///< differences of a scalar potential: no discrete curl
};

/// The form was replaced by the nearest closed one.
struct Projected {
  NotClosed was;
  double changed;  ///< norm of the change over the form's norm
};

/// Circulations of a collocated grid are as accurate as samples between two sizes of voxels, in
/// fine edges, and these voxels are not.
struct VoxelsUnlikeEdges {
  double voxelsPerEdge;
  double finest, coarsest;
};

/// The thesis' boundary method does not keep something on this mesh.
struct MethodLoses {
  std::string what;
};

/// No refined potential has the refined form as its derivative, as refinement does not commute.
struct NoRefinedPotential {};

/// A reason for how a grid is made, with its numbers. wording.h has the words.
using BakeReason = std::variant<NotClosed, LeavesVoid, AroundHandle, Projected, VoxelsUnlikeEdges,
                                MethodLoses, NoRefinedPotential>;

}  // namespace octet
