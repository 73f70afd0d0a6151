// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "local_subdivision.h"

namespace octet {

/// What the spectrum at a vertex says about fields there.
struct Continuity {
  /// Per principal direction: what one step multiplies the coefficients of a constant field by.
  Eigen::Vector3d constants = Eigen::Vector3d::Zero();
  double constantsError = 0;  ///< how far constant fields are from being reproduced, relative
  /// By how much, at most, the part of a field that is not constant grows per step, close to the
  /// vertex and in its own worst direction. Below 1 the field is continuous at the vertex; at 1/2
  /// and below its derivative is bounded, too.
  double growth = 0;
  double eigenvalue = 0;  ///< magnitude of the eigenvalue that `growth` comes from
};

/// @brief Compares the eigenvalues of a degree with those of constant fields, K = 1 or 2.
///
/// Near a vertex a star shrinks by other factors along an extraordinary edge than across it. An
/// eigenform with eigenvalue m whose vectors have a part along principal direction i therefore
/// changes by m / constants[i] per step in that part; parts it does not have do not count. Vectors
/// are those at the corners of the star's tetrahedra, or of its octahedra where it has no others.
/// @param closedOnly  look at closed forms only: incompressible fluxes, curl-free circulations
template <int K>
Continuity continuity(const LocalSubdivision& local, bool closedOnly = false);

}  // namespace octet
