// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <pybind11/pybind11.h>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/core/field/field.h>
#include <octet/core/forms/with_degree.h>

/// @file
/// One function per room of the library; each adds its classes and functions to the module.

namespace octet::python {

namespace py = pybind11;

void bindMesh(py::module_& module);
void bindAsset(py::module_& module);
void bindField(py::module_& module);
void bindRefiner(py::module_& module);
void bindBake(py::module_& module);
void bindCages(py::module_& module);
void bindCertificate(py::module_& module);
void bindFit(py::module_& module);
void bindPrimitives(py::module_& module);
void bindSampling(py::module_& module);
void bindStreamlines(py::module_& module);

/// A form together with the mesh that its simplices are numbered on.
struct MeshForm {
  std::shared_ptr<const ControlMesh> mesh;
  Form form;
};

/// "auto", "walls" or "open"; `methods`: or one of the thesis': "simple", "projection" or
/// "expansion".
BoundaryChoice boundaryChoice(const std::string& name, bool methods);
/// "smooth" or "loop".
BoundaryRows wallSurfaceChoice(const std::string& name);
/// "limit" or "whitney".
Reconstruction reconstructionChoice(const std::string& name);

}  // namespace octet::python
