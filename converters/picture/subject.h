// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <octet/core/base/context.h>
#include <octet/core/field/field.h>

#include "../control_asset/refined_document.h"

namespace octet {

/// Lines and surface that show where a field lives, world units.
struct SubjectShape {
  using Polyline = std::vector<Vec3>;

  std::vector<Polyline> cage;  ///< control edges, straight; of a grid the edges of its box
  std::vector<bool> inner;     ///< per cage line: runs inside, not on the boundary
  std::vector<Polyline> mesh;  ///< boundary edges of a coarser level, as they lie in the limit
  std::vector<Vec3> points;    ///< of the surface
  std::vector<std::array<Index, 3>> triangles;
};

/// @brief What a picture is made of: one vector or scalar field, or none, and the shape of its
/// domain. Cheap to copy apart from the shape; const use is thread safe.
struct Subject {
  /// 1 or 3 numbers at a point in world units; false outside the domain.
  using Sample = std::function<bool(const Vec3& point, double* value)>;

  std::string source;         ///< name of the asset or grid
  std::string form;           ///< name of the form or grid; empty: there is no field
  std::string unit;           ///< of the field's values; empty: unknown
  std::optional<int> degree;  ///< of the form; absent when unknown
  int components = 0;         ///< 0 without a field
  Sample sample;
  Box bounds;         ///< of the domain
  double detail = 0;  ///< mean edge of the finest level, or voxel size
  char upAxis = 'Z';
  SubjectShape shape;
};

/// Which field of an asset, and how it is made.
struct AssetSubjectOptions {
  std::string form;           ///< empty: the first of degree 2, else 1, else any
  int frame = 0;              ///< of an animated form
  std::optional<int> levels;  ///< subdivisions; absent: as many as stay below 100,000 cells
  int meshLevel = 1;          ///< level whose boundary edges are the mesh; at most `levels`
  BoundaryChoice boundary{};
  BoundaryRows wallSurface = BoundaryRows::Smooth;  ///< of the scheme's own rule
  Reconstruction reconstruction = Reconstruction::Limit;
  double zeta = kDefaultZeta;
};

/// The field of a form of a control asset, refined; without forms the shape alone.
/// @throws InputError, Cancelled
Subject assetSubject(const ControlAsset& asset, const AssetSubjectOptions& options,
                     const Context& context = {});

/// A vector or scalar grid of a .vdb (vdb_sampler.h). @param grid  empty: the first vector grid,
/// else the first scalar one. @throws InputError
Subject vdbSubject(const std::string& path, const std::string& grid);

}  // namespace octet
