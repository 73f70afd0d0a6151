// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <octet/core/base/error.h>
#include <octet/core/fit/fit.h>

#include "../../choices.h"
#include "arrays.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

std::vector<double> speedsFrom(const py::object& speeds, py::ssize_t count) {
  if (py::isinstance<py::float_>(speeds) || py::isinstance<py::int_>(speeds)) {
    return {speeds.cast<double>()};
  }
  const auto numbers = finiteNumbers(speeds, "speeds", count);
  return std::vector<double>(numbers.data(), numbers.data() + numbers.size());
}

GuideCurve makeCurve(std::string name, const py::object& points, const py::object& speeds,
                     double weight) {
  const auto numbers = finitePoints(points, "points");
  if (numbers.ndim() != 2) throw InputError("points", "are not of shape (n, 3)");
  GuideCurve curve;
  curve.name = std::move(name);
  const auto list = asPoints(numbers);
  curve.points.assign(list.begin(), list.end());
  curve.speeds = speedsFrom(speeds, numbers.shape(0));
  curve.weight = weight;
  return curve;
}

GuideVector makeVector(std::string name, const py::object& point, const py::object& value,
                       double weight) {
  GuideVector vector;
  vector.name = std::move(name);
  const auto at = finiteNumbers(point, "point", 3), wanted = finiteNumbers(value, "value", 3);
  vector.point = Vec3(at.at(0), at.at(1), at.at(2));
  vector.value = Vec3(wanted.at(0), wanted.at(1), wanted.at(2));
  vector.weight = weight;
  return vector;
}

std::shared_ptr<Fit> makeFit(const ControlMesh& mesh, const std::string& kind, bool closedWalls,
                             const py::object& openFacets, const std::map<Index, double>& flux,
                             double smoothness, int levels, double spacing, double zeta,
                             const py::object& progress) {
  FitOptions options;
  options.kind = choose<FitKind>("kind", kind,
                                 {{"divergence-free", FitKind::DivergenceFree},
                                  {"curl-free", FitKind::CurlFree},
                                  {"free", FitKind::Free}});
  options.closedWalls = closedWalls;
  if (!openFacets.is_none()) {
    const auto list = indexRows(openFacets, "open_facets", 0);
    options.openFacets.assign(list.data(), list.data() + list.size());
  }
  options.flux = flux;
  options.smoothness = smoothness;
  options.levels = levels;
  options.spacing = spacing;
  options.zeta = zeta;
  const Context context = contextOf(progress);
  return withoutGil([&] { return std::make_shared<Fit>(mesh, options, context); });
}

FitResult solveFit(const Fit& fit, std::vector<GuideCurve> curves, std::vector<GuideVector> vectors,
                   const py::object& progress) {
  Guides guides;
  guides.curves = std::move(curves);
  guides.vectors = std::move(vectors);
  const Context context = contextOf(progress);
  return withoutGil([&] { return fit.solve(guides, context); });
}

/// A cochain of the result as a view, or None.
template <int K>
auto cochainView(std::optional<Cochain<K>> FitResult::*member) {
  return [member](const py::object& self) -> py::object {
    const auto& form = self.cast<const FitResult&>().*member;
    if (!form) return py::none();
    return view(form->data(), {form->size()}, self);
  };
}

void bindGuides(py::module_& module) {
  py::class_<GuideCurve>(module, "GuideCurve", py::module_local(),
                         R"(A curve that a field is to follow.

points: float (n, 3), world units; closed when the last is the first
speeds: world units per second, one number or float (n,)
weight: relative to other guides, per unit of length)")
      .def(py::init(&makeCurve), py::arg("name"), py::arg("points"), py::arg("speeds") = 1.0,
           py::arg("weight") = 1.0)
      .def_readonly("name", &GuideCurve::name, "Its name, for messages and reports.")
      .def_readonly("weight", &GuideCurve::weight, "Relative to other guides.")
      .def_property_readonly(
          "points",
          [](const py::object& self) {
            return viewRows(self.cast<const GuideCurve&>().points, 3, self);
          },
          "float64 (n, 3), world units. A view.")
      .def_property_readonly(
          "speeds",
          [](const py::object& self) {
            const auto& speeds = self.cast<const GuideCurve&>().speeds;
            return view(speeds.data(), {static_cast<py::ssize_t>(speeds.size())}, self);
          },
          "float64 (n,) or (1,), world units per second. A view.");
  py::class_<GuideVector>(module, "GuideVector", py::module_local(),
                          R"(A vector that a field is to have at a point.

point: float (3,), world units
value: float (3,), world units per second
weight: counts like a curve that is one mean edge of the cage long, times this)")
      .def(py::init(&makeVector), py::arg("name"), py::arg("point"), py::arg("value"),
           py::arg("weight") = 1.0)
      .def_readonly("name", &GuideVector::name, "Its name, for messages and reports.")
      .def_readonly("weight", &GuideVector::weight, "Relative to other guides.");
}

void bindReports(py::module_& module) {
  py::class_<GuideReport>(module, "GuideReport", py::module_local(),
                          "How well one guide is followed.")
      .def_readonly("name", &GuideReport::name, "The guide's name.")
      .def_readonly("samples", &GuideReport::samples, "Points at which it was compared.")
      .def_readonly("residual", &GuideReport::residual,
                    "Relative error, root mean square: 0.01 is one percent.")
      .def_readonly("worst", &GuideReport::worst, "At one sample, relative to the mean speed.");
  py::class_<GuideConflict>(module, "GuideConflict", py::module_local(),
                            "Guides that ask for different things in nearly the same place.")
      .def_readonly("first", &GuideConflict::first, "Name of the one.")
      .def_readonly("second", &GuideConflict::second, "Name of the other.")
      .def_property_readonly(
          "point",
          [](const GuideConflict& c) {
            return std::array<double, 3>{c.point[0], c.point[1], c.point[2]};
          },
          "Where they disagree most, world units.")
      .def_readonly("disagreement", &GuideConflict::disagreement, "Relative to the greater.");
  py::class_<FitReport>(module, "FitReport", py::module_local(), "How well guides are followed.")
      .def_readonly("guides", &FitReport::guides, "A GuideReport each: curves, then vectors.")
      .def_readonly("residual", &FitReport::residual, "Of all guides, relative.")
      .def_readonly("conflicts", &FitReport::conflicts, "GuideConflicts.")
      .def_readonly("remarks", &FitReport::remarks, "What the user should know.")
      .def_readonly("equations", &FitReport::equations, "Number of equations.")
      .def_readonly("unknowns", &FitReport::unknowns, "Number of unknowns.")
      .def_readonly("wall_flux", &FitReport::wallFlux,
                    "Largest flux through a closed wall's facet before it is set to 0, relative.")
      .def_readonly("divergence", &FitReport::divergence,
                    "Largest divergence of a cell, relative to the largest flux.");
}

void bindResult(py::module_& module) {
  py::class_<FitResult>(module, "FitResult", py::module_local(),
                        "Coefficients on the control mesh, as read-only views.")
      .def_property_readonly("flux", cochainView(&FitResult::flux),
                             "float64 (facets,): the field as a 2-form; None for a curl-free fit.")
      .def_property_readonly("circulation", cochainView(&FitResult::circulation),
                             "float64 (edges,): the field of a curl-free fit as a 1-form, or None.")
      .def_property_readonly("vector_potential", cochainView(&FitResult::vectorPotential),
                             "float64 (edges,): the 1-form whose derivative is the flux, or None.")
      .def_property_readonly("potential", cochainView(&FitResult::potential),
                             "float64 (vertices,): the 0-form whose derivative is the circulation, "
                             "or None.")
      .def_property_readonly(
          "boundary",
          [](const FitResult& r) { return r.mode == BoundaryMode::Walls ? "walls" : "open"; },
          "\"walls\" or \"open\": how the form has to be refined and baked.")
      .def_readonly("report", &FitResult::report, "A FitReport.");
}

}  // namespace

void bindFit(py::module_& module) {
  bindGuides(module);
  bindReports(module);
  bindResult(module);
  py::class_<Fit, std::shared_ptr<Fit>>(
      module, "Fit", py::module_local(),
      R"(Finds the smooth field in a cage that follows guides best.

kind:         "divergence-free" (a 2-form with a vector potential), "curl-free" (a 1-form with a
              potential) or "free" (a 2-form)
closed_walls: no flux through the boundary
open_facets:  int (n,), boundary facets through which the field may pass all the same
flux:         {boundary facet: outward flux, world units cubed per second}
smoothness:   details smaller than this share of the domain's size are smoothed away
levels:       subdivisions at which the field is compared with guides
spacing:      of samples along curves, world units; 0: a quarter of the mean edge
zeta:         free weight of the octahedron's linear rule
progress:     called as progress(stage, done, total, unit); returning False raises Cancelled
Made once per cage and options, solved for any number of sets of guides. Thread safe. Raises
InputError.)")
      .def(py::init(&makeFit), py::arg("mesh"), py::kw_only(), py::arg("kind") = "divergence-free",
           py::arg("closed_walls") = true, py::arg("open_facets") = py::none(),
           py::arg("flux") = std::map<Index, double>(),
           py::arg("smoothness") = FitOptions().smoothness, py::arg("levels") = FitOptions().levels,
           py::arg("spacing") = 0.0, py::arg("zeta") = kDefaultZeta,
           py::arg("progress") = py::none())
      .def("solve", &solveFit, py::arg("curves"), py::arg("vectors") = std::vector<GuideVector>(),
           py::kw_only(), py::arg("progress") = py::none(),
           R"(The field for GuideCurves and GuideVectors, a FitResult.

progress: called as progress(stage, done, total, unit); returning False raises Cancelled
Releases the GIL. Raises InputError for guides outside the domain, or without length or speed, and
when they do not determine the field; Cancelled.)");
}

}  // namespace octet::python
