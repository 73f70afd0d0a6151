// SPDX-License-Identifier: Apache-2.0
#include <octet/converters/gmsh/fill_tetrahedra.h>
#include <octet/converters/surface/fill_surface.h>
#include <octet/core/base/error.h>
#include <octet/core/cage/box_cage.h>
#include <octet/core/cage/quality.h>
#include <octet/core/cage/sharp_edges.h>

#include "arrays.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

Vec3 corner(const py::object& object, const char* name) {
  const auto numbers = finiteNumbers(object, name, 3);
  return Vec3(numbers.at(0), numbers.at(1), numbers.at(2));
}

std::shared_ptr<ControlMesh> makeBoxCage(const py::object& low, const py::object& high,
                                         double spacing) {
  Box box;
  box.min = corner(low, "low");
  box.max = corner(high, "high");
  return withoutGil(
      [&] { return std::make_shared<ControlMesh>(ControlMesh::build(boxCage(box, spacing))); });
}

TriangleSurface surfaceFrom(const py::object& vertices, const py::object& triangles) {
  const auto points = finitePoints(vertices, "vertices");
  if (points.ndim() != 2) throw InputError("vertices", "are not of shape (n, 3)");
  const auto rows = indexRows(triangles, "triangles", 3);
  const auto* const first = reinterpret_cast<const std::array<Index, 3>*>(rows.data());
  return {asPoints(points), {first, first + rows.shape(0)}};
}

std::shared_ptr<ControlMesh> makeFilledCage(const py::object& vertices, const py::object& triangles,
                                            double spacing, double depth, bool fitBoundary,
                                            double sharpAngle, bool allowIntersections,
                                            const py::object& progress) {
  const TriangleSurface surface = surfaceFrom(vertices, triangles);
  FillOptions options;
  options.spacing = spacing;
  options.depth = depth;
  options.fitBoundary = fitBoundary;
  options.sharpAngle = sharpAngle;
  options.allowIntersections = allowIntersections;
  const Context context = contextOf(progress);
  return withoutGil([&] {
    return std::make_shared<ControlMesh>(fillSurface(surface, options, nullptr, context));
  });
}

std::shared_ptr<ControlMesh> makeTetrahedra(const py::object& vertices, const py::object& triangles,
                                            double spacing, double sharpAngle, bool keepTriangles,
                                            const py::object& progress) {
  const TriangleSurface surface = surfaceFrom(vertices, triangles);
  TetrahedraOptions options;
  options.spacing = spacing;
  options.sharpAngle = sharpAngle;
  options.keepTriangles = keepTriangles;
  const Context context = contextOf(progress);
  return withoutGil([&] {
    return std::make_shared<ControlMesh>(fillWithTetrahedra(surface, options, nullptr, context));
  });
}

CageQuality qualityOf(const ControlMesh& mesh) {
  return withoutGil([&] { return measureQuality(*mesh.complex(), mesh.positions()); });
}

}  // namespace

void bindCages(py::module_& module) {
  module.def("box_cage", &makeBoxCage, py::arg("low"), py::arg("high"), py::arg("spacing"),
             R"(A box filled with the regular lattice of tetrahedra and octahedra; walls are flat.

low, high: float (3,), corners, world units
spacing:   edge length of the lattice, world units, about: whole layers fit
Every interior vertex is regular. Raises InputError.)");
  module.def("fill_surface", &makeFilledCage, py::arg("vertices"), py::arg("triangles"),
             py::arg("spacing"), py::kw_only(), py::arg("depth") = 0.5,
             py::arg("fit_boundary") = false, py::arg("sharp_angle") = kSharpAngle,
             py::arg("allow_intersections") = false, py::arg("progress") = py::none(),
             R"(A closed surface filled with the regular lattice of tetrahedra and octahedra.

vertices:  float (n, 3), world units
triangles: int (n, 3), in any orientation
spacing:   edge length of the lattice, world units
depth:     lattice vertices deeper inside than this, in spacings, become interior vertices
fit_boundary: move boundary vertices onto the surface, as far as no cell is inverted
sharp_angle: of a fit: edges where the surface turns by more, in degrees, are followed by creases as
           far as no cell is inverted; 180 makes none
allow_intersections: take a surface that passes through itself for the body it encloses
progress:  called as progress(stage, done, total, unit); returning False raises Cancelled
A part of the surface within another is a cavity. The boundary is a manifold, without a fit within
about a spacing of the surface.
Releases the GIL. Raises InputError: not closed, intersecting itself, too thin for the spacing.)");
  module.def("fill_tetrahedra", &makeTetrahedra, py::arg("vertices"), py::arg("triangles"),
             py::arg("spacing"), py::kw_only(), py::arg("sharp_angle") = kSharpAngle,
             py::arg("keep_triangles") = false, py::arg("progress") = py::none(),
             R"(A closed surface filled with tetrahedra by the program octetvdb-gmsh.

vertices:  float (n, 3), world units
triangles: int (n, 3), in any orientation
spacing:   edge length of the tetrahedra, world units
sharp_angle: edges where the surface turns by more, in degrees, become creases; 180 makes none
keep_triangles: take the surface's triangles as they are; by default they are remeshed unless
           about as large as the spacing
progress:  called as progress(stage, done, total, unit); returning False raises Cancelled
The boundary lies on the surface and follows its sharp edges. A part of the surface within another
is a cavity.
Releases the GIL. Raises InputError: not closed, intersecting or touching itself, too thin for the
spacing, what Gmsh cannot mesh. IoError where octetvdb-gmsh is not installed.)");
  py::class_<CageQuality>(module, "CageQuality", py::module_local(),
                          "How well a control mesh is shaped.")
      .def_readonly("min_dihedral", &CageQuality::minDihedral,
                    "Smallest dihedral angle inside a cell, degrees.")
      .def_readonly("max_dihedral", &CageQuality::maxDihedral,
                    "Largest dihedral angle inside a cell, degrees.")
      .def_readonly("min_volume", &CageQuality::minVolume, "Smallest cell, cubic world units.")
      .def_readonly("max_volume", &CageQuality::maxVolume, "Largest cell, cubic world units.")
      .def_readonly("min_shape", &CageQuality::minShape,
                    "Least of the cells' volumes over those of regular cells with the same longest "
                    "edge.")
      .def_readonly("components", &CageQuality::components, "Parts that share no facet.")
      .def_readonly("touching_vertices", &CageQuality::touchingVertices,
                    "Boundary vertices where the solid touches itself.")
      .def_readonly("touching_edges", &CageQuality::touchingEdges,
                    "Boundary edges where the solid touches itself.");
  module.def("cage_quality", &qualityOf, py::arg("mesh"), "Measures a control mesh.");
}

}  // namespace octet::python
