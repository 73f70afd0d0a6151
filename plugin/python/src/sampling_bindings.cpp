// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <octet/converters/vdb_sampling/sample_velocity.h>
#include <octet/core/base/error.h>

#include "../../choices.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// As many corrections as the command takes.
constexpr int kMostCorrections = 20;

py::tuple sample(const ControlAsset& asset, const std::vector<std::string>& paths,
                 const std::string& name, int degree, bool closed, const std::string& boundary,
                 int corrections, const std::string& grid, const std::string& unit, double scale,
                 int levels, double zeta, const py::object& progress) {
  if (degree != 1 && degree != 2) {
    throw InputError("degree", std::to_string(degree) + " is neither 1 nor 2");
  }
  if (corrections < 0 || corrections > kMostCorrections) {
    throw InputError("corrections", std::to_string(corrections) + " is not from 0 to " +
                                        std::to_string(kMostCorrections));
  }
  SampleOptions options;
  options.name = name;
  options.degree = degree;
  options.closed = closed;
  options.boundary = choose("boundary_flux", boundary, boundaryFluxChoices());
  options.corrections = corrections;
  options.read.grid = grid;
  const VelocityUnit counted = choose("velocity_unit", unit, velocityUnitChoices());
  options.read.voxels = counted.voxels;
  options.read.perFrame = counted.perFrame;
  options.read.framesPerSecond = asset.units.framesPerSecond;
  options.read.scale = scale;
  options.levels = levels;
  options.zeta = zeta;
  const Context context = contextOf(progress);
  auto result = std::make_shared<ControlAsset>(asset);
  auto report = withoutGil([&] { return sampleVelocity(result.get(), paths, options, context); });
  return py::make_tuple(result, py::cast(std::move(report.frames)));
}

}  // namespace

void bindSampling(py::module_& module) {
  py::class_<SampledFrame>(module, "SampledFrame", py::module_local(),
                           R"(What became of one .vdb.

Relative numbers refer to the root mean square speed of the source.)")
      .def_readonly("path", &SampledFrame::path, "The file.")
      .def_readonly("grid", &SampledFrame::grid, "Name of its velocity grid.")
      .def_readonly("frame", &SampledFrame::frame, "Its frame number; None for a single file.")
      .def_readonly("bytes", &SampledFrame::bytes, "Size of the file.")
      .def_readonly("staggered", &SampledFrame::staggered, "Staggered, not collocated?")
      .def_readonly("voxel_size", &SampledFrame::voxelSize, "World units.")
      .def_readonly("active_voxels", &SampledFrame::activeVoxels, "Number of active voxels.")
      .def_readonly("inside", &SampledFrame::inside,
                    "Share of the compared voxels that the cage holds.")
      .def_readonly("speed", &SampledFrame::speed, "Root mean square, world units per second.")
      .def_readonly("error", &SampledFrame::error, "Of the limit field, relative, RMS.")
      .def_readonly("source_divergence", &SampledFrame::sourceDivergence,
                    "RMS, times voxel size, relative.")
      .def_readonly("before", &SampledFrame::before,
                    "Largest derivative of the form as sampled, relative to its largest "
                    "coefficient.")
      .def_readonly("after", &SampledFrame::after, "The same as it was written.");
  module.def("sample_velocity", &sample, py::arg("asset"), py::arg("paths"), py::kw_only(),
             py::arg("name") = "velocity", py::arg("degree") = 2, py::arg("closed") = false,
             py::arg("boundary_flux") = "free", py::arg("corrections") = 0, py::arg("grid") = "",
             py::arg("velocity_unit") = "units/s", py::arg("scale") = 1.0, py::arg("levels") = 2,
             py::arg("zeta") = kDefaultZeta, py::arg("progress") = py::none(),
             R"(Turns velocity grids of .vdb files into a form on an asset's cage.

paths:         one file for a constant form, several, numbered, for an animated one; a name such as
    "vel.####.vdb" stands for all files that are there
name:          of the form; replaces one of that name
degree:        2: fluxes through facets; 1: circulations along edges
closed:        take the nearest form without divergence (degree 2) or curl (1)
boundary_flux: "free", "keep", "zero" or "obstacles": what that does with boundary coefficients;
    "obstacles" makes those of cavities' walls 0, bake then with boundary="walls"
corrections:   how often coefficients are corrected by what the smooth limit lacks, 0 to 20
grid:          name of the vector grid or float triple; found by itself by default
velocity_unit: "units/s", "units/frame", "voxels/s" or "voxels/frame"
scale:         factor for the grid's numbers
levels:        subdivisions at which the limit field is compared with the source
zeta:          free weight of the octahedron's linear rule
progress:      called as progress(stage, done, total, unit); returning False raises Cancelled
Returns a new ControlAsset, and a SampledFrame for each file. Releases the GIL. Raises InputError,
Cancelled.)");
}

}  // namespace octet::python
