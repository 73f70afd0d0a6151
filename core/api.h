// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The public headers of core: what a program includes, all at once or one by one. Other headers
/// are core's own; those that these need are installed with them, and change without notice.
///
/// @defgroup foundations Foundations: numbers and vectors, errors, and the context of long calls
/// @defgroup meshes Meshes: control meshes of tetrahedra and octahedra, and their topology
/// @defgroup forms Forms: coefficients on simplices, the exterior derivative, integration
/// @defgroup subdivision Subdivision: refined meshes and forms
/// @defgroup fields Fields: limits of refined forms, at points and in voxels
/// @defgroup closed Closed forms: the nearest one, and potentials
/// @defgroup making Making forms and cages: primitives, guides, surfaces

/// @ingroup foundations
#include "base/context.h"
#include "base/error.h"
#include "base/types.h"

/// @ingroup meshes
#include "topology/control_mesh.h"

/// @ingroup forms
#include "forms/coboundary.h"
#include "forms/cochain.h"
#include "forms/de_rham.h"
#include "forms/with_degree.h"

/// @ingroup subdivision
#include "field/scheme_subdivision.h"
#include "refine/refiner.h"
#include "refine/subdivision.h"

/// @ingroup fields
#include "field/field.h"
#include "field/limit.h"
#include "raster/flux_rasterizer.h"
#include "raster/rasterizer.h"

/// @ingroup closed
#include "hodge/potential.h"
#include "hodge/projection.h"

/// @ingroup making
#include "cage/lattice_fill.h"
#include "cage/quality.h"
#include "fit/fit.h"
#include "fit/guides.h"
#include "primitives/integrate.h"
#include "streamlines/placement.h"
