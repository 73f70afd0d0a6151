// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "arrays.h"
#include "bindings.h"
#include "field_handle.h"
#include "long_call.h"

namespace octet::python {
namespace {

py::array asBooleans(Array<std::uint8_t> flags, const std::vector<py::ssize_t>& shape) {
  return handOver(std::move(flags), shape).attr("view")("bool").cast<py::array>();
}

template <int C>
py::tuple sample(const Field<C>& field, const py::object& object) {
  static_assert(sizeof(typename Field<C>::Value) == C * sizeof(double));
  const auto points = finitePoints(object, "points");
  const std::size_t count = static_cast<std::size_t>(points.size()) / 3;
  Array<typename Field<C>::Value> values(count);
  Array<std::uint8_t> inside(count);
  withoutGil([&] {
    field.sample(reinterpret_cast<const Vec3*>(points.data()), count, values.data(), inside.data());
  });
  const auto shape = leadingShape(points);
  auto valueShape = shape;
  if (C > 1) valueShape.push_back(C);
  return py::make_tuple(handOver(std::move(values), valueShape),
                        asBooleans(std::move(inside), shape));
}

py::array bounds(const FieldHandle& handle) {
  const Box box = std::visit([](const auto& field) { return field.bounds(); }, handle.field);
  return handOver(Array<Vec3>{box.min, box.max}, {2, 3});
}

}  // namespace

void bindField(py::module_& module) {
  py::class_<FieldHandle>(
      module, "Field", py::module_local(),
      R"(A field that can be sampled at any points of the domain; made by Refiner.field.

Thread safe; needs neither its refiner nor its mesh any more.)")
      .def_property_readonly(
          "components", [](const FieldHandle& h) { return h.field.index() == 0 ? 1 : 3; },
          "1 for functions and densities, 3 for vectors.")
      .def_property_readonly("bounds", &bounds,
                             "float64 (2, 3): lowest and highest corner of the domain's box, world "
                             "units.")
      .def(
          "sample",
          [](const FieldHandle& h, const py::object& points) {
            return std::visit([&](const auto& field) { return sample(field, points); }, h.field);
          },
          py::arg("points"),
          R"(Values at points.

points: float (..., 3), world units; contiguous float64 is used in place.
Returns float64 values of shape (...) or (..., 3), 0 outside the domain; and bool (...), whether the
point lies inside.)")
      .def("__repr__", [](const FieldHandle& h) {
        return std::string("<octetvdb.Field of ") + (h.field.index() == 0 ? "1" : "3") +
               " components>";
      });
}

}  // namespace octet::python
