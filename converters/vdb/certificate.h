// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <octet/core/base/context.h>

#include "metadata.h"

namespace octet {

/// @brief What OpenVDB's own difference operators find in the stored values of a vector grid
/// (SCHEME.md section 9): forward differences for a staggered grid, central ones for any other, as
/// its divergence tool takes. Values that are saved as 16-bit floats are measured as such.
///
/// Inside means: active voxels where every voxel that the operator reads is active too. Divergence
/// and curl are given without unit, times voxel size over largest speed: 1 is a change by the whole
/// speed within a voxel. The curl of a staggered grid is that of backward differences, which is the
/// one that vanishes on differences of a potential; OpenVDB has no tool for it.
struct Certificate {
  std::string scheme;  ///< of the divergence: "FD_1ST" or "CD_2ND"
  std::uint64_t activeVoxels = 0;
  std::uint64_t insideVoxels = 0;  ///< where the divergence was measured
  std::uint64_t freeVoxels = 0;    ///< of these, where it is rounding: at most kFloatDivergence
  double maxDivergence = 0, rmsDivergence = 0;
  std::array<std::int32_t, 3> at{};  ///< voxel of the largest divergence
  double maxCurl = 0, rmsCurl = 0;
  double minSpeed = 0, maxSpeed = 0;  ///< lengths of active values
  double energy = 0;                  ///< integral of half the squared speed, world units
  double outflow = 0;                 ///< net flux out of the active voxels
  double throughflow = 0;             ///< sum of the absolute fluxes through their border
  bool half = false;
  bool partial = false;  ///< of a part of a grid, where it knows what is around a voxel
};

/// Largest divergence that rounding to floats can leave in a grid whose exact divergence is zero.
/// Each of six values is off by half a unit in the last place, 2^-24 of the speed at most; three
/// differences, twice the speed at most, and two sums of them, six times, round once more each.
/// Central differences, over two voxels, have half of it.
inline constexpr double kFloatDivergence = (6 + 3 * 2 + 2 * 6) / 16777216.0;

/// The metadatum that a certificate has when it is of a part only.
inline constexpr const char* kPartialMetadata = "octet_certificate";

/// As grid metadata: names that begin with "octet_".
std::vector<VdbMetadata> toMetadata(const Certificate& certificate);

/// A vector grid of a file, or three float grids that make one, and what was found in it.
struct VerifiedGrid {
  std::string name, type, gridClass;
  double voxelSize = 0;
  Certificate certificate;
};

/// Measures the vector grids of any .vdb, whoever wrote it: vec3s and vec3d grids, and triples of
/// float or double grids named alike up to a last x, y, z or 0, 1, 2 ("vel.x", "velocityX", "v_0").
/// @param name  of the only grid wanted; empty: all
/// @throws InputError when the file cannot be read, has no vector grid or none of that name.
/// Cancelled
std::vector<VerifiedGrid> verifyVdb(const std::string& path, const std::string& name = "",
                                    const Context& context = {});

}  // namespace octet
