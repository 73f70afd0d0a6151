// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <mutex>
#include <optional>

#include <pybind11/stl.h>

#include <octet/core/base/error.h>
#include <octet/core/field/field.h>

#include "arrays.h"
#include "bindings.h"
#include "field_handle.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// A mesh subdivided by the scheme and, once they are asked for, by other rules.
class MeshRefiner {
 public:
  MeshRefiner(std::shared_ptr<ControlMesh> mesh, const RefinerOptions& options,
              const Context& context)
      : mesh_(std::move(mesh)), options_(options), scheme_(*mesh_, options, context) {}

  const std::shared_ptr<ControlMesh>& mesh() const { return mesh_; }
  const SchemeSubdivision& scheme() const { return scheme_; }
  const Refiner& refiner() const { return scheme_.refiner(); }
  /// Call it without the GIL: another thread may be at it, and need the GIL for its progress.
  const Limit& limit(const Context& context) const { return scheme_.limit(context); }
  /// Likewise.
  const Subdivision& by(const BoundaryChoice& choice, const Context& context) const {
    if (choice.mode || choice.name == BoundaryChoice{}.name) return scheme_;
    const std::lock_guard<std::mutex> lock(mutex_);
    auto& subdivision = others_[choice.name];
    if (!subdivision) subdivision = choice.subdivide(*mesh_, options_, context);
    return *subdivision;
  }
  int level(std::optional<int> asked) const {
    const int level = asked.value_or(refiner().levels());
    if (level < 0 || level > refiner().levels()) {
      throw InputError("level", std::to_string(level) + " is not from 0 to " +
                                    std::to_string(refiner().levels()));
    }
    return level;
  }

 private:
  std::shared_ptr<ControlMesh> mesh_;
  RefinerOptions options_;
  SchemeSubdivision scheme_;
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::unique_ptr<const Subdivision>> others_;  // by choice's name
};

template <int K>
Cochain<K> cochain(const py::object& object, const Complex& complex) {
  const auto numbers = finiteNumbers(object, "coefficients", complex.count(K));
  return Cochain<K>(complex, Array<double>(numbers.data(), numbers.data() + numbers.size()));
}

/// The mode that a choice means for coefficients on the control mesh.
template <int K>
BoundaryMode modeFor(const BoundaryChoice& choice, const Complex& control, const Cochain<K>& form) {
  return choice.mode ? *choice.mode : automaticMode(control, form);
}

BoundaryMode knownMode(const std::string& boundary) {
  const auto mode = boundaryChoice(boundary, false).mode;
  if (!mode) {
    throw InputError("boundary",
                     "\"auto\" is for coefficients on the control mesh; here it is "
                     "\"walls\" or \"open\"");
  }
  return *mode;
}

std::shared_ptr<MeshRefiner> makeRefiner(std::shared_ptr<ControlMesh> mesh, int levels, double zeta,
                                         bool smooth, const std::string& wallSurface,
                                         const py::object& progress) {
  RefinerOptions options;
  options.levels = levels;
  options.zeta = zeta;
  options.smooth = smooth;
  options.boundaryRows = wallSurfaceChoice(wallSurface);
  const Context context = contextOf(progress);
  return withoutGil(
      [&] { return std::make_shared<MeshRefiner>(std::move(mesh), options, context); });
}

py::array refine(const MeshRefiner& s, int degree, const py::object& coefficients,
                 const std::string& boundary, const py::object& progress) {
  const Context context = contextOf(progress);
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const BoundaryChoice choice = boundaryChoice(boundary, true);
    auto form = cochain<K>(coefficients, s.refiner().complex(0));
    withoutGil([&] {
      const BoundaryMode mode = modeFor(choice, s.refiner().complex(0), form);
      form = s.by(choice, context.sub(0.3)).refine(form, mode, context);
    });
    return handOver(std::move(form.values()));
  });
}

py::array step(const MeshRefiner& s, int level, int degree, const py::object& coefficients,
               const std::string& boundary) {
  const BoundaryMode mode = knownMode(boundary);
  if (s.level(level) == s.refiner().levels()) {
    throw InputError("level", "there is none after " + std::to_string(level));
  }
  return withDegree(degree, [&](auto constant) {
    auto form = cochain<decltype(constant)::value>(coefficients, s.refiner().complex(level));
    const Context context = contextOf();
    withoutGil([&] { form = s.refiner().step(level, form, mode, context); });
    return handOver(std::move(form.values()));
  });
}

py::array limit(const MeshRefiner& s, int degree, const py::object& coefficients,
                const std::string& boundary, const py::object& progress) {
  const BoundaryMode mode = knownMode(boundary);
  const Context context = contextOf(progress);
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const auto form = cochain<K>(coefficients, s.refiner().finest());
    const py::ssize_t n = s.refiner().finest().vertexCount();
    if constexpr (K == 1 || K == 2) {
      auto vectors =
          withoutGil([&] { return s.limit(context.sub(0.3)).vectors(form, mode, context); });
      return handOver(std::move(vectors), {n, 3});
    } else {
      return handOver(withoutGil([&] {
        if constexpr (K == 0) {
          return s.limit(context.sub(0.3)).values(form, context);
        } else {
          return s.limit(context.sub(0.3)).densities(form, context);
        }
      }));
    }
  });
}

FieldHandle field(const MeshRefiner& s, int degree, const py::object& coefficients,
                  const std::string& boundary, const std::string& reconstruction,
                  const py::object& progress) {
  const Context context = contextOf(progress);
  const BoundaryChoice choice = boundaryChoice(boundary, true);
  const Reconstruction how = reconstructionChoice(reconstruction);
  return withDegree(degree, [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const auto form = cochain<K>(coefficients, s.refiner().complex(0));
    return withoutGil([&] {
      const BoundaryMode mode = modeFor(choice, s.refiner().complex(0), form);
      return FieldHandle(makeField(s.by(choice, context.sub(0.3)), form, mode, how, context));
    });
  });
}

}  // namespace

void bindRefiner(py::module_& module) {
  py::class_<MeshRefiner, std::shared_ptr<MeshRefiner>>(
      module, "Refiner", py::module_local(),
      R"(Subdivides a control mesh and the forms on it.

levels:   number of subdivisions, 0 to 12; each makes about eight times the cells
zeta:     free weight of the octahedron's linear rule
smooth:   False for linear (Whitney) subdivision only
wall_surface: "smooth", or "loop": exactly Loop's surface
progress: called as progress(stage, done, total, unit) while levels are built; returning False
          raises Cancelled, and what it raises is raised

Levels are built once, then applied to any number of forms of degree 0 to 3. Refinement commutes
with the exterior derivative. Methods may be called from many threads; long ones release the GIL.)")
      .def(py::init(&makeRefiner), py::arg("mesh"), py::arg("levels") = 1, py::kw_only(),
           py::arg("zeta") = kDefaultZeta, py::arg("smooth") = true,
           py::arg("wall_surface") = "smooth", py::arg("progress") = py::none())
      .def_property_readonly("mesh", &MeshRefiner::mesh, "The control mesh.")
      .def_property_readonly(
          "levels", [](const MeshRefiner& s) { return s.refiner().levels(); },
          "Number of subdivisions.")
      .def_property_readonly(
          "zeta", [](const MeshRefiner& s) { return s.refiner().zeta(); },
          "Free weight of the octahedron's linear rule.")
      .def_property_readonly(
          "smooth", [](const MeshRefiner& s) { return s.refiner().smooth(); },
          "Smooth subdivision, not just linear?")
      .def(
          "complex",
          [](const MeshRefiner& s, std::optional<int> level) {
            return std::const_pointer_cast<Complex>(s.refiner().sharedComplex(s.level(level)));
          },
          py::arg("level") = py::none(),
          "Topology of a level; 0 is the control mesh, None the finest.")
      .def(
          "positions",
          [](const py::object& self, std::optional<int> level, const std::string& boundary) {
            const auto& s = self.cast<const MeshRefiner&>();
            const int k = s.level(level);
            const BoundaryChoice choice = boundaryChoice(boundary, true);
            const Context context = contextOf();
            const auto& points =
                withoutGil([&]() -> const auto& { return s.by(choice, context).positions(k); });
            return viewRows(points, 3, self);
          },
          py::arg("level") = py::none(), py::arg("boundary") = "auto",
          "float64 (vertices, 3): vertex positions of a level, world units; None: the finest.\n"
          "The thesis' methods at the boundary have positions of their own. A view.")
      .def(
          "limit_positions",
          [](const py::object& self) {
            const auto& s = self.cast<const MeshRefiner&>();
            const Context context = contextOf();
            const auto& points =
                withoutGil([&]() -> const auto& { return s.limit(context).positions(); });
            return viewRows(points, 3, self);
          },
          "float64 (vertices, 3): limits of the finest level's vertices, world units. A view.")
      .def("refine", &refine, py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary") = "auto", py::kw_only(), py::arg("progress") = py::none(),
           R"(Coefficients on the finest level from those on the control mesh.

coefficients: float (mesh.complex.count(degree),)
boundary:     "walls": what is zero at the boundary stays zero; "open": constants are exact there;
              "auto": walls for forms that are zero there; for comparison, the thesis' methods:
              "simple", "projection", "expansion"
progress:     called as progress(stage, done, total, unit); returning False raises Cancelled
Returns float64 (complex().count(degree),).)")
      .def("step", &step, py::arg("level"), py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary"),
           "Coefficients on level + 1 from those on a level; boundary is \"walls\" or \"open\".")
      .def("limit", &limit, py::arg("degree"), py::arg("coefficients"), py::arg("boundary"),
           py::kw_only(), py::arg("progress") = py::none(),
           R"(Limits at the finest level's vertices, of coefficients on the finest level.

Returns float64 (vertices,): values of a 0-form, densities of a 3-form; or float64 (vertices, 3):
vectors of a 1-form, flux densities of a 2-form. boundary is "walls" or "open". progress as in
refine.)")
      .def("field", &field, py::arg("degree"), py::arg("coefficients"),
           py::arg("boundary") = "auto", py::arg("reconstruction") = "limit", py::kw_only(),
           py::arg("progress") = py::none(),
           R"(The field of a form given on the control mesh, to be sampled at points.

reconstruction: "limit", smooth and second order; or "whitney", the Whitney form on the finest level)")
      .def("__repr__", [](const MeshRefiner& s) {
        return "<octetvdb.Refiner: " + std::to_string(s.refiner().levels()) + " levels, " +
               std::to_string(s.refiner().finest().cellCount()) + " cells>";
      });
}

}  // namespace octet::python
