// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../remesh.h"

namespace octet::gmsh_import {

/// What the functions of remesh.h promise, done in this process.
TriangleSurface orientedByCgal(const TriangleSurface& surface);
RemeshedSurface remeshByCgal(const TriangleSurface& surface, const RemeshOptions& options,
                             const Context& context);
TriangleSurface withoutSliversByCgal(const TriangleSurface& surface);

}  // namespace octet::gmsh_import
