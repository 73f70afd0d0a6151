// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <pybind11/stl.h>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/base/error.h>

#include "arrays.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// What control assets hold at most (control_asset.cpp): grids have 32-bit floats.
constexpr double kLargestValue = 1e30;

void checkName(const std::string& name) {
  if (name.empty()) throw InputError("name", "is empty");
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) {
      throw InputError("name", "has a control character, such as a line break");
    }
  }
}

std::vector<double> formValues(const py::object& object, const std::string& place, Index count) {
  const auto numbers = finiteNumbers(object, place.c_str(), count);
  const double* const data = numbers.data();
  for (Index k = 0; k < count; ++k) {
    if (std::abs(data[k]) > kLargestValue) {
      throw InputError(place + "[" + std::to_string(k) + "]", "is larger than 1e30");
    }
  }
  return std::vector<double>(data, data + count);
}

/// Leaves out simplices that are 0 in every frame, as `makeForm` does.
void dropZeros(Form* form) {
  const auto isZero = [&](std::size_t k) {
    if (!form->animated()) return form->values[k] == 0;
    for (const auto& [frame, values] : form->frames) {
      if (values[k] != 0) return false;
    }
    return true;
  };
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < form->simplices.size(); ++k) {
    if (!isZero(k)) kept.push_back(k);
  }
  const auto keep = [&](auto* list) {
    for (std::size_t i = 0; i < kept.size(); ++i) (*list)[i] = (*list)[kept[i]];
    list->resize(kept.size());
  };
  keep(&form->simplices);
  keep(&form->signs);
  if (!form->animated()) keep(&form->values);
  for (auto& [frame, values] : form->frames) keep(&values);
}

std::shared_ptr<MeshForm> makeMeshForm(std::shared_ptr<ControlMesh> mesh, std::string name,
                                       int degree, const py::object& values,
                                       const py::object& frames, std::string unit) {
  checkName(name);
  if (values.is_none() == frames.is_none()) {
    throw InputError("values", values.is_none() ? "are missing: give them or frames"
                                                : "are given twice, "
                                                  "also as frames");
  }
  const Index count =
      withDegree(degree, [&](auto constant) { return mesh->complex()->count(constant); });
  Form form;
  form.name = std::move(name);
  form.degree = degree;
  form.unit = std::move(unit);
  form.signs.assign(count, 1);
  for (Index i = 0; i < count; ++i) form.simplices.push_back(i);
  if (frames.is_none()) {
    form.values = formValues(values, "values", count);
  } else {
    for (const auto& [key, list] : frames.cast<py::dict>()) {
      const int frame = key.cast<int>();
      const std::string place = "frames[" + std::to_string(frame) + "]";
      if (std::abs(frame) > kLastFrame) throw InputError(place, "is no frame number");
      form.frames[frame] = formValues(py::reinterpret_borrow<py::object>(list), place, count);
    }
    if (form.frames.empty()) throw InputError("frames", "are empty");
  }
  dropZeros(&form);
  return std::make_shared<MeshForm>(MeshForm{std::move(mesh), std::move(form)});
}

/// Dense coefficients of a form, along the stored orientations.
py::array denseCoefficients(const MeshForm& f, int frame) {
  ControlAsset asset;
  asset.mesh = *f.mesh;
  return withDegree(f.form.degree, [&](auto constant) {
    auto form = coefficients<decltype(constant)::value>(asset, f.form, frame);
    return handOver(std::move(form.values()));
  });
}

std::vector<int> frameNumbers(const MeshForm& f) {
  std::vector<int> numbers;
  for (const auto& [frame, values] : f.form.frames) numbers.push_back(frame);
  return numbers;
}

std::shared_ptr<ControlAsset> makeAsset(const ControlMesh& mesh,
                                        const std::vector<std::shared_ptr<MeshForm>>& forms,
                                        std::string name, const std::string& upAxis,
                                        double metersPerUnit, double framesPerSecond) {
  auto asset = std::make_shared<ControlAsset>();
  asset->mesh = mesh;
  asset->name = std::move(name);
  if (upAxis != "Y" && upAxis != "Z") {
    throw InputError("up_axis", "\"" + upAxis + "\" is neither \"Y\" nor \"Z\"");
  }
  const auto positive = [](double x, const char* place) {
    if (!(x > 0) || !std::isfinite(x)) throw InputError(place, "is not a positive number");
    return x;
  };
  asset->units = {upAxis[0], positive(metersPerUnit, "meters_per_unit"),
                  positive(framesPerSecond, "frames_per_second")};
  for (std::size_t k = 0; k < forms.size(); ++k) {
    const std::string place = "forms[" + std::to_string(k) + "]";
    if (!forms[k]) throw InputError(place, "is None");
    const Form& form = forms[k]->form;
    if (forms[k]->mesh->complex() != mesh.complex()) {
      throw InputError(place, "\"" + form.name + "\" was made on another mesh");
    }
    for (const Form& other : asset->forms) {
      if (other.name == form.name) throw InputError(place, "\"" + form.name + "\" appears twice");
    }
    asset->forms.push_back(form);
  }
  return asset;
}

/// The asset's mesh, which keeps the asset alive.
std::shared_ptr<ControlMesh> meshOf(const std::shared_ptr<ControlAsset>& asset) {
  return std::shared_ptr<ControlMesh>(asset, &asset->mesh);
}

void bindForm(py::module_& module) {
  py::class_<MeshForm, std::shared_ptr<MeshForm>>(
      module, "Form", py::module_local(),
      R"(Coefficients of a discrete form on a control mesh, constant or one set per frame. Immutable.

degree: 0 values at vertices, 1 circulations along edges (unit of the field times length),
        2 fluxes through facets (times area), 3 integrals over cells (times volume)
values: float (mesh.complex.count(degree),), along the stored orientations; or
frames: {frame number: such an array}
unit:   a note for people, kept in files)")
      .def(py::init(&makeMeshForm), py::arg("mesh"), py::arg("name"), py::arg("degree"),
           py::arg("values") = py::none(), py::kw_only(), py::arg("frames") = py::none(),
           py::arg("unit") = "")
      .def_property_readonly(
          "name", [](const MeshForm& f) { return f.form.name; }, "Its name.")
      .def_property_readonly(
          "degree", [](const MeshForm& f) { return f.form.degree; }, "0, 1, 2 or 3.")
      .def_property_readonly(
          "unit", [](const MeshForm& f) { return f.form.unit; },
          "Unit of the coefficients, as noted in the asset.")
      .def_property_readonly("frames", &frameNumbers,
                             "Frame numbers, ascending; empty for a constant form.")
      .def_property_readonly(
          "mesh", [](const MeshForm& f) { return std::const_pointer_cast<ControlMesh>(f.mesh); },
          "The mesh it lives on.")
      .def("coefficients", &denseCoefficients, py::arg("frame") = 0,
           R"(float64 (count(degree),): the coefficients along the stored orientations.

A frame that the form lacks takes the nearest earlier one (the first, before all). A new array.)")
      .def("__repr__", [](const MeshForm& f) {
        return "<octetvdb.Form \"" + f.form.name + "\" of degree " + std::to_string(f.form.degree) +
               ", " + std::to_string(f.form.simplices.size()) + " coefficients>";
      });
}

}  // namespace

void bindAsset(py::module_& module) {
  bindForm(module);
  py::class_<ControlAsset, std::shared_ptr<ControlAsset>>(
      module, "ControlAsset", py::module_local(),
      R"(A control mesh with forms on it: what everything else starts from. Immutable.

up_axis:           "Z" or "Y"
meters_per_unit:   length of a world unit
frames_per_second: of the frames of animated forms)")
      .def(py::init(&makeAsset), py::arg("mesh"),
           py::arg("forms") = std::vector<std::shared_ptr<MeshForm>>(), py::kw_only(),
           py::arg("name") = "", py::arg("up_axis") = "Z", py::arg("meters_per_unit") = 1.0,
           py::arg("frames_per_second") = 24.0)
      .def_static(
          "read",
          [](const std::string& path) {
            return withoutGil(
                [&] { return std::make_shared<ControlAsset>(readControlAsset(path)); });
          },
          py::arg("path"),
          "Reads *.octet.json, or the same document as CBOR (*.octet).\n\n"
          "Raises InputError with the file, the place and the reason.")
      .def(
          "write",
          [](const ControlAsset& asset, const std::string& path) {
            withoutGil([&] { writeControlAsset(asset, path); });
          },
          py::arg("path"),
          "Writes the asset, as CBOR when the name ends in .octet. The file appears complete or\n"
          "not at all. Raises IoError.")
      .def_property_readonly("mesh", &meshOf, "The control mesh.")
      .def_property_readonly(
          "forms",
          [](const std::shared_ptr<ControlAsset>& asset) {
            std::vector<std::shared_ptr<MeshForm>> forms;
            for (const Form& form : asset->forms) {
              forms.push_back(std::make_shared<MeshForm>(MeshForm{meshOf(asset), form}));
            }
            return forms;
          },
          "The forms, in their order.")
      .def(
          "form",
          [](const std::shared_ptr<ControlAsset>& asset, const std::string& name) {
            return std::make_shared<MeshForm>(MeshForm{meshOf(asset), asset->form(name)});
          },
          py::arg("name"), "The form of that name; raises InputError listing the names there are.")
      .def_readonly("name", &ControlAsset::name, "Its name.")
      .def_property_readonly(
          "up_axis", [](const ControlAsset& a) { return std::string(1, a.units.upAxis); },
          "\"Z\" or \"Y\".")
      .def_property_readonly(
          "meters_per_unit", [](const ControlAsset& a) { return a.units.metersPerUnit; },
          "Length of a world unit, metres.")
      .def_property_readonly(
          "frames_per_second", [](const ControlAsset& a) { return a.units.framesPerSecond; },
          "Rate of the frames of animated forms.")
      .def_property_readonly("frame_range", &ControlAsset::frameRange,
                             "First and last frame over all animated forms; None when constant.")
      .def("__repr__", [](const ControlAsset& a) {
        return "<octetvdb.ControlAsset \"" + a.name +
               "\": " + std::to_string(a.mesh.complex()->cellCount()) + " cells, " +
               std::to_string(a.forms.size()) + " forms>";
      });
}

}  // namespace octet::python
