// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include <pybind11/stl.h>

#include <octet/core/base/error.h>
#include <octet/core/streamlines/placement.h>

#include "arrays.h"
#include "bindings.h"
#include "field_handle.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// Seeds keep this share of the distance that `count` evenly spread points would have.
constexpr double kSeedSpacing = 0.6;
/// Lines shorter than this share of the separation only clutter a picture.
constexpr double kShortest = 0.5;
/// Longest step and length, as a share of the domain's diagonal.
constexpr double kLongestStep = 0.01, kLongest = 4;

const VectorField& vectorField(const FieldHandle& handle) {
  if (const auto* field = std::get_if<VectorField>(&handle.field)) return *field;
  throw InputError("field", "has one component, not three");
}

VelocityFunction velocityOf(const VectorField& field) {
  return [field](const Vec3& point, Vec3* velocity) { return field.sample(point, velocity); };
}

std::size_t asCount(int count) {
  if (count < 1) throw InputError("count", "is less than 1");
  return static_cast<std::size_t>(count);
}

/// Distance between points when `count` of them fill a box evenly.
double evenDistance(const Box& box, int count) {
  return std::cbrt(box.size().prod() / static_cast<double>(count));
}

std::vector<py::array> placeLines(const FieldHandle& handle, int count, double separation,
                                  double tolerance, const py::object& progress) {
  const VectorField& field = vectorField(handle);
  const Box& box = field.bounds();
  const double diagonal = box.size().norm();
  PlacementOptions options;
  options.count = asCount(count);
  options.separation = separation > 0 ? separation : kSeedSpacing * evenDistance(box, count);
  options.shortest = kShortest * options.separation;
  options.lines.tolerance = tolerance * diagonal;
  options.lines.longestStep = kLongestStep * diagonal;
  options.lines.longest = kLongest * diagonal;
  options.lines.closing = options.lines.longestStep / 2;
  const Context context = contextOf(progress);
  const auto lines =
      withoutGil([&] { return placeStreamlines(velocityOf(field), box, options, context); });
  std::vector<py::array> result;
  for (const Streamline& line : lines) {
    Array<Vec3> points(line.points.size());
    for (std::size_t k = 0; k < points.size(); ++k) points[k] = line.points[k].position;
    const auto n = static_cast<py::ssize_t>(points.size());
    result.push_back(handOver(std::move(points), {n, 3}));
  }
  return result;
}

py::array placePoints(const FieldHandle& handle, int count, double distance) {
  auto points = withoutGil([&] {
    return std::visit(
        [&](const auto& field) {
          const double apart =
              distance > 0 ? distance : kSeedSpacing * evenDistance(field.bounds(), count);
          const auto inside = [&](const Vec3& p) {
            typename std::decay_t<decltype(field)>::Value unused;
            return field.sample(p, &unused);
          };
          return spacedPoints(inside, field.bounds(), asCount(count), apart);
        },
        handle.field);
  });
  const auto n = static_cast<py::ssize_t>(points.size());
  return handOver(std::move(points), {n, 3});
}

}  // namespace

void bindStreamlines(py::module_& module) {
  module.def("streamlines", &placeLines, py::arg("field"), py::arg("count"), py::kw_only(),
             py::arg("separation") = 0.0, py::arg("tolerance") = 1e-5,
             py::arg("progress") = py::none(),
             R"(Streamlines that fill a field's domain evenly.

count:      at most so many
separation: no seed lies nearer to an earlier line, world units; 0: as count asks for
tolerance:  estimated error of one step, as a share of the domain's diagonal
progress:   called as progress(stage, done, total, unit); returning False raises Cancelled
Returns a list of float64 (n, 3), points along the flow. The same for any number of threads.)");
  module.def(
      "spaced_points", &placePoints, py::arg("field"), py::arg("count"), py::arg("distance") = 0.0,
      R"(Points in a field's domain that keep a distance from each other, the same ones always.

distance: world units; 0: as count asks for
Returns float64 (n, 3), n at most count.)");
}

}  // namespace octet::python
