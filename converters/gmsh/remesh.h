// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <octet/core/base/context.h>
#include <octet/core/cage/sharp_edges.h>

/// @file
/// What CGAL does to surfaces, in the program octetvdb-gmsh.

namespace octet {

struct RemeshOptions {
  double edgeLength = 0;            ///< wanted, world units
  double sharpAngle = kSharpAngle;  ///< edges that turn by more, in degrees, are kept
};

struct RemeshedSurface {
  TriangleSurface surface;
  std::vector<std::array<Index, 2>> creases;  ///< its edges on sharp edges of the surface given
  std::vector<Index> corners;                 ///< its vertices on corners of these, ascending
};

/// @brief The surface with triangles turned to agree with their neighbours.
/// @throws InputError for edges without two triangles, vertices at which the surface touches
/// itself, and one-sided surfaces; IoError as askGmsh (gmsh_program.h)
TriangleSurface oriented(const TriangleSurface& surface, const Context& context = {});

/// @brief Triangles about as large as wanted for a closed surface, whatever its own are, by CGAL:
/// edges are split, collapsed and turned, and vertices moved along the surface, until edges are
/// about as long as wanted (M. Botsch, L. Kobbelt, A remeshing approach to multiresolution
/// modeling, 2004).
///
/// Vertices lie on the surface given, to rounding. Sharp edges stay, but for connected ones shorter
/// than two edges: their corners are vertices, and vertices on them move along them only. Triangles
/// come out as `oriented`; where the surface is finer than the wanted edges, as around thin parts,
/// they stay smaller. Deterministic, one thread but for searches. That the result does not
/// intersect itself is for findSelfIntersection to tell.
/// @throws as oriented; Cancelled
RemeshedSurface remesh(const TriangleSurface& surface, const RemeshOptions& options,
                       const Context& context = {});

/// @brief The surface without triangles so flat that their normals, and with these the sharp edges
/// at them, are rounding, such as CAD programs write: edges of no length are collapsed, and long
/// edges that run past a vertex turned, by CGAL. No vertex moves. Where that is not possible
/// triangles stay.
/// @throws as oriented; Cancelled
TriangleSurface withoutSlivers(const TriangleSurface& surface, const Context& context = {});

}  // namespace octet
