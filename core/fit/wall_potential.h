// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <vector>

#include "../topology/complex.h"

namespace octet {

/// Given flux through boundary facets, along their stored orientation, one entry per facet of the
/// complex; absent where it is free. 0 is a wall.
using GivenFlux = std::vector<std::optional<double>>;

/// @brief All vector potentials A (1-forms) whose flux d A through some boundary facets is as
/// given: A = basis x + particular, with x free.
///
/// On walls A is not just 0: it may be any closed 1-form of the wall surface, whose classes are the
/// fluxes through the handles of the domain (a flow around a ring has them). Up to gradients, which
/// change no flux, these are found by a spanning tree of the wall's vertices and one of its facets:
/// A is 0 on the first, and the second's edges follow from the others, facet by facet.
struct WallPotential {
  Eigen::SparseMatrix<double> basis;  ///< edges x unknowns, entries 0, +1, -1 but for rare sums
  Eigen::VectorXd particular;         ///< per edge
  /// Vertices at which a gradient may still be added to A, changing nothing.
  std::vector<std::uint8_t> gaugeVertices;
};

/// @throws InputError when the flux through a closed part of the boundary does not add up to 0.
WallPotential makeWallPotential(const Complex& complex, const GivenFlux& flux);

}  // namespace octet
