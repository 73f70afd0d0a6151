// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bake_options.h"
#include "bake_reason.h"
#include "domain_shape.h"

/// @file
/// What a bake is going to do, decided before it does it. All functions here are pure: the same
/// options and facts make the same plan. Facts are found by bake_facts.h; form_baker.h carries a
/// plan out.

namespace octet {

/// What is known of a mesh and its first level.
struct MeshFacts {
  double controlEdge = 0;        ///< mean edge of the control mesh
  double longestSide = 0;        ///< of the box around the limit surface
  double firstEdge = 0;          ///< mean edge of level 1, between limit positions
  double tets = 0, octs = 0;     ///< of the control mesh
  AxisTurn turn{};               ///< from the asset's axes to the target's
  DomainShape domain{};          ///< what level 1 fills, in the target's axes
  int scalars = 0, vectors = 0;  ///< grids of a file
};

/// How fine a bake is, and what it foresees to take.
struct ResolutionPlan {
  double voxelSize = 0;  ///< world units
  int levels = 0;        ///< subdivisions
  double cells = 0;      ///< at the finest level
  double fineEdge = 0;   ///< mean edge there, about
  double voxels = 0;     ///< of each grid, about
  double meshBytes = 0;  ///< of memory for the refined mesh and fields on it, at most
  double gridBytes = 0;  ///< for the grids of a file
  double bytes() const { return meshBytes + gridBytes; }
};

/// Takes the voxel size that is given, or follows from a resolution along the domain's longest
/// side; the levels that are given, or the fewest whose mean fine edge is at most two voxels.
/// @throws InputError for sizes that are none
ResolutionPlan planResolution(const BakeOptions& options, const MeshFacts& facts);

/// Finds the most voxels along the longest side for which a bake takes at most `memory` bytes, with
/// the levels that options give, if they do; 0 when there is no such number.
int largestResolution(const BakeOptions& options, const MeshFacts& facts, double memory);

/// @throws MemoryError when the bake that is planned needs more than `memory` bytes
void checkMemory(const ResolutionPlan& plan, const BakeOptions& options, const MeshFacts& facts,
                 double memory);

/// What is known of the refined mesh: measured, or foreseen.
struct RefinementFacts {
  double fineEdge = 0;    ///< mean edge of the finest level
  bool hasLimits = true;  ///< else fields are Whitney forms
  bool commutes = true;   ///< with d, so that a refined potential's derivative is the refined form
  std::string methodLoses;     ///< what the boundary method does not keep; empty: nothing
  std::string boundaryRule{};  ///< name of its own rule for the boundary, if it has one
};

/// What is known before forms are planned.
struct BakeFacts {
  char upAxis = 'Z';  ///< of the asset
  ResolutionPlan resolution;
  RefinementFacts refinement;

  double voxelsPerEdge() const { return resolution.voxelSize / refinement.fineEdge; }
};

/// What is known of a form at one frame; of its derivative, when that is baked.
struct FormFacts {
  std::string name, unit;  ///< of the form
  std::string grid;        ///< name of its grid
  int degree = 0;
  BoundaryMode mode = BoundaryMode::Walls;
  std::optional<Projected> projected{};
  std::optional<NotClosed> open{};
  /// Of a potential, when it was looked for: is there one, and why not, or what can it not do?
  bool hasPotential = false;
  std::optional<VelocityPlan::Flaw> flaw{};
};

/// How one grid is made. Later decisions, such as levels that differ over the mesh, get their place
/// here.
struct BakePlan {
  std::string form, unit, grid;
  int degree = 0;  ///< of what is baked
  ResolutionPlan resolution;
  AxisTurn turn;              ///< from the asset's axes to the target's
  Vec3 shift = Vec3::Zero();  ///< of the grid's transform against its samples
  BoundaryMode mode = BoundaryMode::Walls;
  std::string boundaryRule{};  ///< of the subdivision, in place of a mode
  Reconstruction reconstruction = Reconstruction::Limit;
  GridMethod method = GridMethod::None;
  Sampling sampling = Sampling::Collocated;
  double neighbours = 0;           ///< weight in means of collocated circulations (neighbourWeight)
  std::optional<GridPart> part{};  ///< which part of the grid; none: all
  std::vector<BakeReason> reasons;
};

/// From an asset's axes to those that a target wants.
AxisTurn turnFor(char upAxis, const BakeOptions& options);

/// @throws InputError when the method that is asked for needs what refinement does not give
void checkMethod(const BakeOptions& options, const RefinementFacts& refinement);

/// Is a potential needed to plan a form of this degree? Else it need not be looked for.
bool seeksPotential(int degree, const BakeOptions& options, const BakeFacts& facts);

/// Plans the grid of a form. @throws InputError when it must be conservative and cannot be
BakePlan planBake(const FormFacts& form, const BakeOptions& options, const BakeFacts& facts);

}  // namespace octet
