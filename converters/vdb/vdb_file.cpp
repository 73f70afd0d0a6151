// SPDX-License-Identifier: Apache-2.0
#include "vdb_file.h"

#include <cmath>

#include <openvdb/openvdb.h>

#include <octet/core/raster/difference_rasterizer.h>
#include <octet/core/raster/flux_rasterizer.h>
#include <octet/core/raster/rasterizer.h>
#include <octet/version.h>

#include "fill_grid.h"
#include "measure_grid.h"
#include "vdb_input.h"
#include "vdb_output.h"
#include "wording.h"

namespace octet {
namespace {

openvdb::math::Transform::Ptr linearTransform(double voxelSize) {
  try {
    return openvdb::math::Transform::createLinearTransform(voxelSize);
  } catch (const openvdb::ArithmeticError&) {
    throw InputError("voxel size", "is too small for OpenVDB; scale the asset up");
  }
}

void setClass(const VdbGridSpec& spec, openvdb::GridBase* grid) {
  switch (spec.gridClass) {
    case VdbGridSpec::Class::Staggered:
      return grid->setGridClass(openvdb::GRID_STAGGERED);
    case VdbGridSpec::Class::Fog:
      return grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    case VdbGridSpec::Class::Unknown:
      return grid->setGridClass(openvdb::GRID_UNKNOWN);
  }
}

/// What a spec says about a grid, but for its values.
void label(const VdbGridSpec& spec, openvdb::GridBase* grid) {
  grid->setName(spec.name);
  auto transform = linearTransform(spec.frame.voxelSize);
  const Vec3 origin = spec.frame.origin + spec.shift;
  transform->postTranslate(openvdb::Vec3d(origin[0], origin[1], origin[2]));
  grid->setTransform(transform);
  setClass(spec, grid);
  grid->setSaveFloatAsHalf(spec.half);
  grid->setCreator(std::string("OctetVDB ") + kVersion);
  addMetadata(grid, spec.metadata);
  if (spec.part) addMetadata(grid, toMetadata(*spec.part));
}

/// Labels a vector grid, with how it was made and its certificate.
/// @param sampled  how many voxels hold samples, where others hold values of the method
VdbGridInfo finish(const VdbGridSpec& spec, GridMethod method, std::uint64_t sampled,
                   const Context& context, openvdb::Vec3SGrid* grid) {
  label(spec, grid);
  grid->setVectorType(spec.vectorType == VdbGridSpec::VectorType::Covariant
                          ? openvdb::VEC_COVARIANT
                          : openvdb::VEC_CONTRAVARIANT_RELATIVE);
  const std::string sampling = spec.sampling == Sampling::Staggered ? "staggered" : "collocated";
  addMetadata(grid, {{kSamplingMetadata, sampling},
                     {kMethodMetadata, std::string(methodName(method))},
                     {kSampledMetadata, static_cast<double>(sampled)}});
  if (!spec.reasons.empty()) addMetadata(grid, {{"octet_note", words(spec.reasons)}});
  const Certificate certificate = measureGrid(*grid, context);
  addMetadata(grid, toMetadata(certificate));
  VdbGridInfo info = describeUnmeasured(*grid);
  info.leaves = grid->tree().leafCount();
  info.min = certificate.minSpeed;
  info.max = certificate.maxSpeed;
  info.certificate = certificate;
  info.method = method;
  info.sampledVoxels = sampled;
  info.reasons = spec.reasons;
  return info;
}

/// Windows that make up a frame's, for rasterizeDifferences(), which keeps potential and vectors of
/// all tiles of its window as doubles: so thin, along the longest side, that this is small beside
/// the grid or the mesh, since each costs a look at all cells.
std::vector<IndexBox> slabsFor(const GradientField& field, const GridFrame& frame) {
  constexpr double kBytesPerTile = sizeof(Tile<3>) + sizeof(Tile<1>);
  constexpr double kShareOfGrid = 0.25, kBytesPerCell = 100;
  constexpr double kGridBytesPerTile = Tile<3>::kSize * sizeof(openvdb::Vec3f);
  const Complex& complex = field.base.source().complex();
  const Box box = field.base.bounds();
  IndexBox tiles;
  double count = 1;
  int axis = 0;
  for (int k = 0; k < 3; ++k) {
    const auto tileAt = [&](double x) {
      return std::floor((x - frame.origin[k]) / frame.voxelSize / Tile<1>::kWidth);
    };
    const double limit = kTileLimit;
    tiles.min[k] = static_cast<GridIndex>(std::clamp(tileAt(box.min[k]), -limit, limit - 1));
    tiles.max[k] = static_cast<GridIndex>(std::clamp(tileAt(box.max[k]), -limit, limit - 1));
  }
  tiles = intersection(tiles, frame.window);
  if (tiles.empty()) return {frame.window};
  for (int k = 0; k < 3; ++k) {
    count *= tiles.max[k] - tiles.min[k] + 1.0;
    if (tiles.max[k] - tiles.min[k] > tiles.max[axis] - tiles.min[axis]) axis = k;
  }
  const double most = std::max(kShareOfGrid * count * kGridBytesPerTile,
                               kBytesPerCell * static_cast<double>(complex.cellCount()));
  const GridIndex layers = tiles.max[axis] - tiles.min[axis] + 1;
  const double perLayer = count / layers * kBytesPerTile;
  // With a layer on either side.
  const GridIndex thick =
      std::max<GridIndex>(2, static_cast<GridIndex>(std::min<double>(layers, most / perLayer - 2)));
  std::vector<IndexBox> slabs;
  for (GridIndex first = tiles.min[axis]; first <= tiles.max[axis]; first += thick) {
    IndexBox slab = frame.window;
    if (first > tiles.min[axis]) slab.min[axis] = first;
    if (first + thick <= tiles.max[axis]) slab.max[axis] = first + thick - 1;
    slabs.push_back(slab);
  }
  return slabs;
}

}  // namespace

struct VdbFile::Grids {
  openvdb::GridCPtrVec list;
};

VdbFile::VdbFile() : grids_(std::make_unique<Grids>()) {
  openvdb::initialize();  // does nothing the second time
}
VdbFile::~VdbFile() = default;
VdbFile::VdbFile(VdbFile&&) noexcept = default;

VdbGridInfo VdbFile::add(const VectorField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterize<3>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name,
                     context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Samples, grid->activeVoxelCount(), context, grid.get());
}

VdbGridInfo VdbFile::add(const PotentialField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterizeFluxes(field, spec.frame, sink, "bake " + spec.name, context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Circulations, 0, context, grid.get());
}

VdbGridInfo VdbFile::add(const MeanFluxField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        rasterize<3>(field.samples.source(), spec.frame, Sampling::Collocated, sink,
                     "sample " + spec.name, context.sub(0.3));
      },
      spec);
  const std::uint64_t replaced = replaceValues(
      [&](const auto& sink) {
        rasterizeMeanFluxes(field.potential, spec.frame, field.neighbours, sink,
                            "bake " + spec.name, context.sub(0.8));
      },
      spec, grid.get());
  grids_->list.push_back(grid);
  return finish(spec, replaced ? GridMethod::Circulations : GridMethod::Samples,
                grid->activeVoxelCount() - replaced, context, grid.get());
}

VdbGridInfo VdbFile::add(const GradientField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::Vec3SGrid, 3>(
      [&](const auto& sink) {
        const auto slabs = slabsFor(field, spec.frame);
        for (const IndexBox& slab : slabs) {
          GridFrame frame = spec.frame;
          frame.window = slab;
          rasterizeDifferences(field, frame, spec.sampling, sink, "bake " + spec.name,
                               context.sub(0.8 / static_cast<double>(slabs.size())));
        }
      },
      spec);
  grids_->list.push_back(grid);
  return finish(spec, GridMethod::Differences, 0, context, grid.get());
}

VdbGridInfo VdbFile::add(const ScalarField& field, const VdbGridSpec& spec,
                         const Context& context) {
  const auto grid = fillGrid<openvdb::FloatGrid, 1>(
      [&](const auto& sink) {
        rasterize<1>(field.source(), spec.frame, spec.sampling, sink, "bake " + spec.name,
                     context.sub(0.8));
      },
      spec);
  grids_->list.push_back(grid);
  label(spec, grid.get());
  VdbGridInfo info = describe(*grid, context);
  info.reasons = spec.reasons;
  return info;
}

void VdbFile::write(const std::string& path, const std::vector<VdbMetadata>& fileMetadata,
                    const Context& context) const {
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata(std::string("OctetVDB ") + kVersion));
  addMetadata(&metadata, fileMetadata);
  writeVdb(path, grids_->list, metadata, context);
}

}  // namespace octet
