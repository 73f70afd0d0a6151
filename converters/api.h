// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The public headers of the converters, between files and core: what a program includes, all at
/// once or one by one. Pictures are a library of their own: picture/picture.h and exr/slice_exr.h.
///
/// @defgroup assets Assets: control meshes with forms, in files
/// @defgroup grids Grids: OpenVDB files, baked, measured and sampled
/// @defgroup sources Sources of cages and forms: surfaces, primitives, guides

/// @ingroup assets
#include "control_asset/control_asset.h"
#include "control_asset/refined_document.h"

/// @ingroup grids
#include "vdb/bake.h"
#include "vdb/certificate.h"
#include "vdb/vdb_sampler.h"
#include "vdb_sampling/sample_velocity.h"

/// @ingroup sources
#include "gmsh/fill_tetrahedra.h"
#include "gmsh/gmsh_import.h"
#include "guides/guide_file.h"
#include "primitives/primitive_list.h"
#include "surface/fill_surface.h"
