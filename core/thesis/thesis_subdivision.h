// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../refine/refiner.h"
#include "../refine/subdivision.h"

namespace octet {

/// The thesis' three answers to what subdivision does at the boundary (its chapter 5), beside the
/// walls and open rules of the scheme.
///
/// Here stands in short what each keeps on any mesh, `exactly` for to rounding;
/// samples/thesis/boundary makes a table of it.
enum class ThesisMethod : std::uint8_t {
  /// Interior rules with the cells there are; circulations and fluxes on the boundary become 0
  /// (5.2). Fields die out towards the boundary, positions shrink away from it. Degree 0 refines
  /// exactly linear functions of position, forms lose their boundary; d does not commute there. In
  /// the interior it is the scheme without its patch test.
  Simple,
  /// Simplices that touch the boundary take the derivatives of polynomials fitted to their coarse
  /// layer (5.3). Constants exactly. Inside, constant fluxes are exact by the patch test
  /// (inner_patch_test.h). At the boundary a fit is made on the cells around a boundary vertex,
  /// constants first, then what is left by d of quadratic potentials (circulations) or d(linear) ^
  /// d(quadratic) (fluxes), if the layer has twice as many coefficients. Potentials are subdivided,
  /// as numbers at vertices, by the rule of degree 0; a simplex takes the mean over its boundary
  /// vertices. Scaling: a boundary vertex does not move along the normals of its facets, and
  /// potentials change along by their own slope. d does not commute at the boundary: what is not d
  /// of a quadratic there is lost.
  Projection,
  /// A virtual layer around the mesh, carried along, makes the boundary interior (5.4, 5.5).
  /// Constants exactly, and d commutes with all degrees, so that what is curl-free or
  /// incompressible stays so, unless the mesh has a gap that the layer fills (extension.h,
  /// virtual_layer.h); `commutes()` tells. On a lattice block everything is the scheme on the
  /// infinite lattice. A constant density is kept on lattice blocks; elsewhere it changes next to
  /// the boundary. Only this method has limits.
  Expansion,
};

/// The names that commands and files know methods by: "simple", "projection", "expansion".
const char* methodName(ThesisMethod method);

/// Subdivides by one of the thesis' methods, whose name is then the boundaryRule().
/// @param options  patchTest and boundaryRows are the method's own and not looked at
/// @throws InputError as Refiner, and for a mesh that cannot be expanded
std::unique_ptr<Subdivision> subdivideByThesis(const ControlMesh& mesh, ThesisMethod method,
                                               const RefinerOptions& options = {},
                                               const Context& context = {});

}  // namespace octet
