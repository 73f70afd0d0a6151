// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <pybind11/pybind11.h>

#include <octet/converters/control_asset/refined_document.h>
#include <octet/core/field/field.h>

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

/// Calls `use(integral_constant<int, K>)` with the degree as a constant.
/// @throws InputError when it is none of 0 to 3
template <typename Use>
auto withDegree(int degree, const Use& use) {
  switch (degree) {
    case 0:
      return use(std::integral_constant<int, 0>{});
    case 1:
      return use(std::integral_constant<int, 1>{});
    case 2:
      return use(std::integral_constant<int, 2>{});
    case 3:
      return use(std::integral_constant<int, 3>{});
    default:
      throw InputError("degree", std::to_string(degree) + " is not 0, 1, 2 or 3");
  }
}

/// "auto", "walls" or "open".
BoundaryChoice boundaryChoice(const std::string& name);
/// The same, or one of the thesis' methods: "simple", "projection" or "expansion".
BoundaryChoice boundaryOrMethod(const std::string& name);
/// "limit" or "whitney".
Reconstruction reconstructionChoice(const std::string& name);

}  // namespace octet::python
