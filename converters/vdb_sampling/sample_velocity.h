// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <octet/core/base/context.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/rules/linear_rules.h>

#include "../control_asset/control_asset.h"
#include "velocity_source.h"

namespace octet {

struct SampleOptions {
  std::string name = "velocity";  ///< of the form; replaces one of that name
  int degree = 2;                 ///< 2: fluxes through facets; 1: circulations along edges
  /// Take the nearest closed form instead: without divergence (degree 2) or curl (degree 1).
  bool closed = false;
  /// What that does with boundary coefficients. After ZeroInside bake with BoundaryMode::Walls: the
  /// flux through the outer boundary would make `auto` take all of it for open.
  BoundaryRule boundary = BoundaryRule::Free;
  /// Subdivision smooths: the limit of a source's own fluxes is weaker than the source in what is
  /// as small as a cell. Each correction adds to the coefficients what the limit's fluxes lack.
  int corrections = 0;
  VelocityReadOptions read;
  int levels = 2;  ///< at which the limit field is compared with the source
  std::size_t mostPoints = std::size_t{1} << 20;  ///< of a frame at which they are compared
  double zeta = kDefaultZeta;
  std::optional<std::vector<int>> frames;  ///< of sequences; absent: all files that are there
};

/// What became of one file. Relative numbers refer to the root mean square speed of the source.
struct SampledFrame {
  std::string path, grid;
  std::optional<int> frame;
  std::uint64_t bytes = 0;  ///< of the file, with all its grids
  bool staggered = false;
  double voxelSize = 0;
  std::uint64_t activeVoxels = 0;
  double inside = 0;            ///< share of the compared voxels that the cage holds
  double speed = 0;             ///< root mean square over the compared voxels
  double error = 0;             ///< of the limit field there, relative, root mean square
  double sourceDivergence = 0;  ///< root mean square, times voxel size, relative
  /// Largest |d w| relative to the largest |w|, as sampled and as written.
  double before = 0, after = 0;
};

struct SampleReport {
  std::vector<SampledFrame> frames;
  std::uint64_t sourceBytes = 0;
};

/// @brief Turns velocity grids into a form of a control asset by the de Rham map: how caches of
/// simulations are compressed and cleaned. One file becomes a constant form; several become an
/// animated one, numbered by the last digits of their names. A name with a place for the frame
/// (io/frames.h) stands for a sequence.
///
/// Fluxes and circulations are integrated with pieces of a voxel's size (CompositeDeRham). Where
/// the cage lies outside the grid its background, usually 0, counts.
/// @throws InputError, Cancelled; the asset is then untouched.
SampleReport sampleVelocity(ControlAsset* asset, const std::vector<std::string>& names,
                            const SampleOptions& options, const Context& context = {});

}  // namespace octet
