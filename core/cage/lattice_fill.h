// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "../base/context.h"
#include "../geometry/box_bins.h"
#include "../topology/control_mesh.h"

namespace octet {

/// Signed distance to a body's surface in world units, negative inside. Far from the surface any
/// value of the right sign will do that is farther than one lattice edge. Called from many threads.
using SignedDistance = std::function<double(const Vec3&)>;

struct LatticeFillOptions {
  double spacing = 0;  ///< edge length of the lattice, world units
  /// Lattice vertices deeper inside than this, in spacings, become interior vertices. The default
  /// makes the unfitted cage about as big as the body.
  double depth = 0.5;
};

/// How a fill went.
struct LatticeFillReport {
  Index interiorVertices = 0;    ///< all of type R
  Index components = 0;          ///< parts of the cage that share no facet
  Index added = 0, dropped = 0;  ///< interior vertices changed for a better boundary
};

/// @brief Fills a body with the regular face-centred cubic lattice of tetrahedra and octahedra.
///
/// The cage is the union of the complete stars of the lattice vertices that lie deep enough inside.
/// So every interior vertex is of type R, every cell has an interior vertex (none collapses when
/// the boundary is fitted), and boundary vertices lie within about a spacing of the surface, on
/// either side. The boundary is a manifold: where stars meet only in a vertex or an edge, interior
/// vertices are added or dropped, the nearest to the threshold first. No creases, no corners.
///
/// The lattice has a vertex at the centre of `bounds`, so a symmetric body gets a symmetric cage.
/// The result does not depend on the number of threads.
/// @param bounds  holds the body
/// @throws InputError when nothing of the body is deep enough ("too coarse"), for a spacing that is
/// no positive number, and for more than kMostCageCells cells. Cancelled.
ControlMeshInput fillLattice(const Box& bounds, const SignedDistance& distance,
                             const LatticeFillOptions& options, LatticeFillReport* report = nullptr,
                             const Context& context = {});

}  // namespace octet
