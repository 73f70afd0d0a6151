// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/base/context.h>
#include <octet/core/cage/sharp_edges.h>
#include <octet/core/topology/control_mesh.h>

namespace octet {

/// Most tetrahedra that are asked of Gmsh, which makes some 10,000 a second.
inline constexpr std::int64_t kMostTetrahedra = 5'000'000;

struct TetrahedraOptions {
  double spacing = 0;  ///< edge length wanted, world units
  /// Edges at which the surface turns by more, in degrees, become creases; 180 makes none.
  double sharpAngle = kSharpAngle;
  bool keepTriangles = false;  ///< take the surface's triangles as they are, whatever their size
};

struct TetrahedraReport {
  double bodyVolume = 0;  ///< of what the surface encloses, less cavities
  Index bodies = 0, cavities = 0;
  bool remeshed = false;       ///< or the surface's own triangles are the boundary
  double surfaceDistance = 0;  ///< largest, of boundary facets' centroids from the surface
  double sharpLength = 0;      ///< of the surface's sharp edges
  double creaseLength = 0;     ///< of the creases; chords of curved sharp edges are shorter
};

/// @brief A control mesh of tetrahedra that fills a closed surface, by Gmsh.
///
/// The boundary is the surface itself where its edges are about as long as the spacing, else the
/// surface remeshed at the spacing by CGAL (remesh.h); its vertices lie on the surface, its creases
/// follow the surface's sharp edges, and corners of these are corners. A part of the surface within
/// another is a cavity, one within a cavity a body again, whichever way the triangles are oriented.
/// Gmsh and CGAL run in a program of their own, Gmsh limited in time and memory (gmsh_program.h).
/// @throws InputError for a surface that is not closed, intersects or touches itself, or encloses
/// nothing; for a spacing that is not positive, makes too many cells, or is too coarse for the
/// body; for what Gmsh cannot mesh. IoError without octetvdb-gmsh. Cancelled.
ControlMesh fillWithTetrahedra(const TriangleSurface& surface, const TetrahedraOptions& options,
                               TetrahedraReport* report = nullptr, const Context& context = {});

}  // namespace octet
