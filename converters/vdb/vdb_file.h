// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <octet/core/field/gradient_field.h>
#include <octet/core/hodge/potential_field.h>
#include <octet/core/raster/rasterizer.h>

#include "bake_reason.h"
#include "certificate.h"
#include "grid_part.h"

namespace octet {

/// How a field becomes an OpenVDB grid.
struct VdbGridSpec {
  enum class Class { Unknown, Staggered, Fog };
  enum class VectorType { Covariant, ContravariantRelative };

  std::string name;
  Class gridClass = Class::Unknown;
  VectorType vectorType = VectorType::ContravariantRelative;  ///< of a vector grid
  GridFrame frame;                                            ///< where samples are taken
  std::optional<GridPart> part;  ///< which part of the grid; its window is the frame's
  Vec3 shift = Vec3::Zero();     ///< by which the written transform differs from the frame
  Sampling sampling = Sampling::Collocated;
  bool half = false;                ///< save as 16-bit floats
  std::vector<BakeReason> reasons;  ///< for how a vector grid is made
  std::vector<VdbMetadata> metadata;
};

/// @brief A collocated velocity whose central differences cancel inside: mean fluxes of the
/// potential where they can be had (rasterizeMeanFluxes), and samples in the voxels that remain,
/// near the boundary.
struct MeanFluxField {
  VectorField samples;
  PotentialField potential;
  double neighbours;  ///< weight of each neighbour (neighbourWeight)
};

/// What was put into a grid, or found in one.
struct VdbGridInfo {
  std::string name, type, gridClass, vectorType;
  double voxelSize = 0;
  std::uint64_t activeVoxels = 0, leaves = 0;
  double min = 0, max = 0;  ///< of active values; of the length, for vectors
  std::array<std::int32_t, 3> indexMin{}, indexMax{};
  bool half = false;
  std::vector<VdbMetadata> metadata;
  GridMethod method = GridMethod::None;    ///< how a vector grid was made
  std::uint64_t sampledVoxels = 0;         ///< active voxels that hold samples all the same
  std::vector<BakeReason> reasons;         ///< for that
  std::optional<Certificate> certificate;  ///< of a vector grid that was just made
};

/// @brief Collects grids and writes them to one .vdb file, which appears complete or not at all.
/// Grids are filled leaf by leaf in parallel; voxels outside the domain stay inactive.
class VdbFile {
 public:
  VdbFile();
  ~VdbFile();
  VdbFile(VdbFile&&) noexcept;

  /// Samples a field on a grid: vectors to vec3s, scalars to float.
  /// @throws InputError (voxel size), Cancelled
  VdbGridInfo add(const VectorField& field, const VdbGridSpec& spec, const Context& context = {});
  /// The curl of a potential, with a discrete divergence of zero (flux_rasterizer.h): staggered.
  VdbGridInfo add(const PotentialField& field, const VdbGridSpec& spec,
                  const Context& context = {});
  /// What is active is what samples alone would make active.
  VdbGridInfo add(const MeanFluxField& field, const VdbGridSpec& spec, const Context& context = {});
  /// Differences of a potential, with a discrete curl of zero (difference_rasterizer.h).
  VdbGridInfo add(const GradientField& field, const VdbGridSpec& spec, const Context& context = {});
  VdbGridInfo add(const ScalarField& field, const VdbGridSpec& spec, const Context& context = {});

  /// The same grids make the same bytes: the file's unique tag is made from its content.
  /// @throws IoError, Cancelled
  void write(const std::string& path, const std::vector<VdbMetadata>& fileMetadata = {},
             const Context& context = {}) const;

 private:
  struct Grids;
  std::unique_ptr<Grids> grids_;
};

/// @throws InputError for the name of a file to write that does not end in .vdb: what holds grids
/// must not look like something else
void checkVdbName(const std::string& path);

/// Reads what a .vdb holds. @throws InputError when it cannot be read.
std::vector<VdbGridInfo> readVdbInfo(const std::string& path,
                                     std::vector<VdbMetadata>* fileMetadata = nullptr,
                                     const Context& context = {});

}  // namespace octet
