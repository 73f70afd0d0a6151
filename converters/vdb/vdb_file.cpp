// SPDX-License-Identifier: Apache-2.0
#include "vdb_file.h"

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
        rasterizeDifferences(field, spec.frame, spec.sampling, sink, "bake " + spec.name,
                             context.sub(0.8));
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
