// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <octet/converters/vdb/certificate.h>

#include "bindings.h"
#include "long_call.h"

namespace octet::python {

void bindCertificate(py::module_& module) {
  py::class_<Certificate>(module, "Certificate", py::module_local(),
                          R"(What OpenVDB's own difference operators find in a stored vector grid.

Divergence and curl are times voxel size over largest speed, and taken where all voxels that the
operator reads are active. Grids saved as 16-bit floats are measured as such.)")
      .def_readonly("scheme", &Certificate::scheme,
                    "Of the divergence: \"FD_1ST\" (staggered) or \"CD_2ND\".")
      .def_readonly("active_voxels", &Certificate::activeVoxels, "Number of active voxels.")
      .def_readonly("inside_voxels", &Certificate::insideVoxels,
                    "Number of voxels where the divergence was measured.")
      .def_readonly("free_voxels", &Certificate::freeVoxels,
                    "Number of these where it is rounding: at most 24 / 2**24.")
      .def_readonly("max_divergence", &Certificate::maxDivergence, "Largest divergence.")
      .def_readonly("rms_divergence", &Certificate::rmsDivergence, "Its root mean square.")
      .def_readonly("at", &Certificate::at, "Index of the voxel of the largest divergence.")
      .def_readonly("max_curl", &Certificate::maxCurl, "Largest curl.")
      .def_readonly("rms_curl", &Certificate::rmsCurl, "Its root mean square.")
      .def_readonly("min_speed", &Certificate::minSpeed, "Least length of an active value.")
      .def_readonly("max_speed", &Certificate::maxSpeed, "Largest length of an active value.")
      .def_readonly("energy", &Certificate::energy,
                    "Integral of half the squared speed, world units.")
      .def_readonly("outflow", &Certificate::outflow, "Net flux out of the active voxels.")
      .def_readonly("throughflow", &Certificate::throughflow,
                    "Sum of the absolute fluxes through their border.")
      .def_readonly("half", &Certificate::half, "Saved as 16-bit floats?")
      .def_readonly("partial", &Certificate::partial,
                    "Of a part of a grid, where it knows what is around a voxel?");
  py::class_<VerifiedGrid>(module, "VerifiedGrid", py::module_local(),
                           "A vector grid of a .vdb, or three float grids that make one.")
      .def_readonly("name", &VerifiedGrid::name, "Its name.")
      .def_readonly("type", &VerifiedGrid::type, "OpenVDB's value type.")
      .def_readonly("grid_class", &VerifiedGrid::gridClass, "OpenVDB's grid class.")
      .def_readonly("voxel_size", &VerifiedGrid::voxelSize, "Voxel size, world units.")
      .def_readonly("certificate", &VerifiedGrid::certificate, "What was measured.");
  module.def(
      "verify",
      [](const std::string& path, const std::string& grid) {
        const Context context = contextOf();
        return withoutGil([&] { return verifyVdb(path, grid, context); });
      },
      py::arg("path"), py::arg("grid") = "",
      R"(Measures the vector grids of any .vdb, whoever wrote it; a VerifiedGrid each.

grid: name of the only grid wanted; all by default
Releases the GIL. Raises InputError.)");
}

}  // namespace octet::python
