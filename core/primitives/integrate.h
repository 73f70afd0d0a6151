// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../base/context.h"
#include "../forms/cochain.h"
#include "primitive.h"

namespace octet {

/// @brief The de Rham map of a primitive: circulations along edges (K = 1) or fluxes through facets
/// (K = 2), in closed form, but for vortex rings (to 1e-12 of the circulation).
///
/// Fluxes of all but sources are the circulations of a vector potential around facets, so d w = 0
/// to rounding; those of a source are solid angles, so d w is its strength in the cell that holds
/// it (in one of two when it lies on a facet, shared among those at an edge or a vertex) and 0
/// elsewhere. Circulations of uniform flows and sources have d w = 0; a singular vortex line gives
/// the facets it pierces its circulation. Parallel; the same at any number of threads.
/// @throws InputError for a primitive that checkPrimitive refuses, a vortex line without core along
/// an edge, and for K = 1 a source without core at a vertex or a ring without core. Cancelled
template <int K>
Cochain<K> integrate(const Primitive& primitive, const Complex& complex,
                     const Array<Vec3>& positions, const Context& context = {});

}  // namespace octet
