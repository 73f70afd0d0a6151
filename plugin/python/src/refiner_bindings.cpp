// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <mutex>
#include <optional>

#include <pybind11/stl.h>

#include <octet/core/base/error.h>
#include <octet/core/boundary_methods/method_refiner.h>
#include <octet/core/field/field.h>
#include <octet/core/refine/refiner.h>

#include "arrays.h"
#include "bindings.h"
#include "field_handle.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// A refiner with its limit and the thesis' boundary methods, which are made when first needed.
class Subdivision {
 public:
  Subdivision(std::shared_ptr<ControlMesh> mesh, const RefinerOptions& options)
      : mesh_(std::move(mesh)), options_(options), refiner_(*mesh_, options) {
    options_.progress = {};  // of whoever made this
  }

  const Refiner& refiner() const { return refiner_; }
  const std::shared_ptr<ControlMesh>& mesh() const { return mesh_; }
  /// Call it without the GIL: another thread may be at it, and need the GIL for its progress.
  const Limit& limit() const {
    std::call_once(once_, [&] { limit_.emplace(refiner_); });
    return *limit_;
  }
  /// Likewise.
  const MethodRefiner& method(BoundaryMethod which) const {
    const auto k = static_cast<std::size_t>(which);
    std::call_once(methodOnce_[k], [&] { methods_[k].emplace(*mesh_, which, options_); });
    return *methods_[k];
  }
  int level(std::optional<int> asked) const {
    const int level = asked.value_or(refiner_.levels());
    if (level < 0 || level > refiner_.levels()) {
      throw InputError("level", std::to_string(level) + " is not from 0 to " +
                                    std::to_string(refiner_.levels()));
    }
    return level;
  }

 private:
  std::shared_ptr<ControlMesh> mesh_;
  RefinerOptions options_;
  Refiner refiner_;
  mutable std::once_flag once_;
  mutable std::optional<Limit> limit_;
  mutable std::array<std::once_flag, 3> methodOnce_;
  mutable std::array<std::optional<MethodRefiner>, 3> methods_;  // by BoundaryMethod
};

template <int K>
Cochain<K> cochain(const py::object& object, const Complex& complex) {
  const auto numbers = finiteNumbers(object, "coefficients", complex.count(K));
  return Cochain<K>(Array<double>(numbers.data(), numbers.data() + numbers.size()));
}

/// The mode that a choice means for coefficients on the control mesh.
template <int K>
BoundaryMode modeFor(BoundaryChoice choice, const Complex& control, const Cochain<K>& form) {
  if (choice == BoundaryChoice::Auto) return automaticMode(control, form);
  return choice == BoundaryChoice::Walls ? BoundaryMode::Walls : BoundaryMode::Open;
}

BoundaryMode knownMode(const std::string& boundary) {
  if (boundary == "auto") {
    throw InputError("boundary",
                     "\"auto\" is for coefficients on the control mesh; here it is "
                     "\"walls\" or \"open\"");
  }
  return boundaryChoice(boundary) == BoundaryChoice::Walls ? BoundaryMode::Walls
                                                           : BoundaryMode::Open;
}

std::shared_ptr<Subdivision> makeSubdivision(std::shared_ptr<ControlMesh> mesh, int levels,
                                             double zeta, bool smooth, const py::object& progress) {
  RefinerOptions options;
  options.levels = levels;
  options.zeta = zeta;
  options.smooth = smooth;
  options.progress = progressCallback(progress);
  return withoutGil([&] { return std::make_shared<Subdivision>(std::move(mesh), options); });
}

py::array refine(const Subdivision& s, int degree, const py::object& coefficients,
                 const std::string& boundary) {
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const BoundaryChoice choice = boundaryOrMethod(boundary);
    auto form = cochain<K>(coefficients, s.refiner().complex(0));
    withoutGil([&] {
      if (const auto method = boundaryMethod(choice)) {
        form = s.method(*method).refine(form);
        return;
      }
      const BoundaryMode mode = modeFor(choice, s.refiner().complex(0), form);
      form = s.refiner().refine(std::move(form), mode);
    });
    return handOver(std::move(form.values()));
  });
}

py::array step(const Subdivision& s, int level, int degree, const py::object& coefficients,
               const std::string& boundary) {
  const BoundaryMode mode = knownMode(boundary);
  if (s.level(level) == s.refiner().levels()) {
    throw InputError("level", "there is none after " + std::to_string(level));
  }
  return withDegree(degree, [&](auto constant) {
    auto form = cochain<decltype(constant)::value>(coefficients, s.refiner().complex(level));
    withoutGil([&] { form = s.refiner().step(level, form, mode); });
    return handOver(std::move(form.values()));
  });
}

py::array limit(const Subdivision& s, int degree, const py::object& coefficients,
                const std::string& boundary) {
  const BoundaryMode mode = knownMode(boundary);
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const auto form = cochain<K>(coefficients, s.refiner().finest());
    const py::ssize_t n = s.refiner().finest().vertexCount();
    if constexpr (K == 1 || K == 2) {
      auto vectors = withoutGil([&] { return s.limit().vectors(form, mode); });
      return handOver(std::move(vectors), {n, 3});
    } else {
      return handOver(withoutGil([&] {
        if constexpr (K == 0) {
          return s.limit().values(form);
        } else {
          return s.limit().densities(form);
        }
      }));
    }
  });
}

FieldHandle field(const Subdivision& s, int degree, const py::object& coefficients,
                  const std::string& boundary, const std::string& reconstruction) {
  const BoundaryChoice choice = boundaryOrMethod(boundary);
  const Reconstruction how = reconstructionChoice(reconstruction);
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    auto form = cochain<K>(coefficients, s.refiner().complex(0));
    return withoutGil([&] {
      if (const auto method = boundaryMethod(choice)) {
        return FieldHandle(s.method(*method).field(form, how));
      }
      const BoundaryMode mode = modeFor(choice, s.refiner().complex(0), form);
      form = s.refiner().refine(std::move(form), mode);
      return FieldHandle(makeField(s.refiner(), s.limit(), std::move(form), mode, how));
    });
  });
}

}  // namespace

void bindRefiner(py::module_& module) {
  py::class_<Subdivision, std::shared_ptr<Subdivision>>(
      module, "Refiner", py::module_local(),
      R"(Subdivides a control mesh and the forms on it.

levels:   number of subdivisions, 0 to 12; each makes about eight times the cells
zeta:     free weight of the octahedron's linear rule
smooth:   False for linear (Whitney) subdivision only
progress: called as progress(stage, done, total, unit) while levels are built; returning False
          raises Cancelled, and what it raises is raised

Levels are built once, then applied to any number of forms of degree 0 to 3. Refinement commutes
with the exterior derivative. Methods may be called from many threads; long ones release the GIL.)")
      .def(py::init(&makeSubdivision), py::arg("mesh"), py::arg("levels") = 1, py::kw_only(),
           py::arg("zeta") = kDefaultZeta, py::arg("smooth") = true,
           py::arg("progress") = py::none())
      .def_property_readonly("mesh", &Subdivision::mesh, "The control mesh.")
      .def_property_readonly(
          "levels", [](const Subdivision& s) { return s.refiner().levels(); },
          "Number of subdivisions.")
      .def_property_readonly(
          "zeta", [](const Subdivision& s) { return s.refiner().zeta(); },
          "Free weight of the octahedron's linear rule.")
      .def_property_readonly(
          "smooth", [](const Subdivision& s) { return s.refiner().smooth(); },
          "Smooth subdivision, not just linear?")
      .def(
          "complex",
          [](const Subdivision& s, std::optional<int> level) {
            return std::const_pointer_cast<Complex>(s.refiner().sharedComplex(s.level(level)));
          },
          py::arg("level") = py::none(),
          "Topology of a level; 0 is the control mesh, None the finest.")
      .def(
          "positions",
          [](const py::object& self, std::optional<int> level, const std::string& boundary) {
            const auto& s = self.cast<const Subdivision&>();
            const int k = s.level(level);
            const auto method = boundaryMethod(boundaryOrMethod(boundary));
            const auto& points = withoutGil([&]() -> const auto& {
              return method ? s.method(*method).positions(k) : s.refiner().positions(k);
            });
            return viewRows(points, 3, self);
          },
          py::arg("level") = py::none(), py::arg("boundary") = "auto",
          "float64 (vertices, 3): vertex positions of a level, world units; None: the finest.\n"
          "The thesis' methods at the boundary have positions of their own. A view.")
      .def(
          "limit_positions",
          [](const py::object& self) {
            const auto& s = self.cast<const Subdivision&>();
            const auto& points = withoutGil([&]() -> const auto& { return s.limit().positions(); });
            return viewRows(points, 3, self);
          },
          "float64 (vertices, 3): limits of the finest level's vertices, world units. A view.")
      .def("refine", &refine, py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary") = "auto",
           R"(Coefficients on the finest level from those on the control mesh.

coefficients: float (mesh.complex.count(degree),)
boundary:     "walls": what is zero at the boundary stays zero; "open": constants are exact there;
              "auto": walls for forms that are zero there; for comparison, the thesis' methods:
              "simple", "projection", "expansion"
Returns float64 (complex().count(degree),).)")
      .def("step", &step, py::arg("level"), py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary"),
           "Coefficients on level + 1 from those on a level; boundary is \"walls\" or \"open\".")
      .def("limit", &limit, py::arg("degree"), py::arg("coefficients"), py::arg("boundary"),
           R"(Limits at the finest level's vertices, of coefficients on the finest level.

Returns float64 (vertices,): values of a 0-form, densities of a 3-form; or float64 (vertices, 3):
vectors of a 1-form, flux densities of a 2-form. boundary is "walls" or "open".)")
      .def("field", &field, py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary") = "auto", py::arg("reconstruction") = "limit",
           R"(The field of a form given on the control mesh, to be sampled at points.

reconstruction: "limit", smooth and second order; or "whitney", the Whitney form on the finest level)")
      .def("__repr__", [](const Subdivision& s) {
        return "<octetvdb.Refiner: " + std::to_string(s.refiner().levels()) + " levels, " +
               std::to_string(s.refiner().finest().cellCount()) + " cells>";
      });
}

}  // namespace octet::python
