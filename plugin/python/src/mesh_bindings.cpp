// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <octet/core/forms/coboundary.h>
#include <octet/core/topology/control_mesh.h>

#include "arrays.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

template <std::size_t N>
Array<std::array<Index, N>> cellRows(const py::object& object, const char* name) {
  if (object.is_none()) return {};
  const auto rows = indexRows(object, name, N);
  const auto* const first = reinterpret_cast<const std::array<Index, N>*>(rows.data());
  return Array<std::array<Index, N>>(first, first + rows.shape(0));
}

std::shared_ptr<ControlMesh> buildMesh(const py::object& vertices, const py::object& tetrahedra,
                                       const py::object& octahedra, const py::object& creases,
                                       const py::object& corners) {
  ControlMeshInput input;
  const auto points = finitePoints(vertices, "vertices");
  if (points.ndim() != 2) throw InputError("vertices", "are not of shape (n, 3)");
  input.vertices = asPoints(points);
  input.tets = cellRows<4>(tetrahedra, "tetrahedra");
  input.octs = cellRows<6>(octahedra, "octahedra");
  if (!creases.is_none()) {
    const auto rows = cellRows<2>(creases, "creases");
    input.creases.emplace(rows.begin(), rows.end());
  }
  if (!corners.is_none()) {
    const auto list = indexRows(corners, "corners", 0);
    input.corners.assign(list.data(), list.data() + list.size());
  }
  return withoutGil(
      [&] { return std::make_shared<ControlMesh>(ControlMesh::build(std::move(input))); });
}

py::array facetTriples(const Complex& complex) {
  Array<std::array<Index, 3>> triples(complex.facetCount());
  for (Index f = 0; f < complex.facetCount(); ++f) triples[f] = complex.facetVertices(f);
  return handOver(std::move(triples), {complex.facetCount(), 3});
}

template <typename Accept>
py::array indicesWhere(Index count, const Accept& accept) {
  std::vector<Index> indices;
  for (Index i = 0; i < count; ++i) {
    if (accept(i)) indices.push_back(i);
  }
  return handOver(std::move(indices));
}

py::array creaseEdges(const Complex& complex) {
  std::vector<std::array<Index, 2>> rows;
  for (Index e = 0; e < complex.edgeCount(); ++e) {
    if (complex.edgeFlags[e] & kOnCrease) rows.push_back(complex.edges[e]);
  }
  const auto count = static_cast<py::ssize_t>(rows.size());
  return handOver(std::move(rows), {count, 2});
}

/// Indices and signs (+1 along the stored orientation) of simplices given by their vertices.
template <std::size_t N, typename Find>
py::tuple findSimplices(const py::object& object, const char* name, const Complex& complex,
                        const Find& find) {
  const auto rows = cellRows<N>(object, name);
  std::vector<Index> indices;
  std::vector<std::int8_t> signs;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const std::string place = std::string(name) + "[" + std::to_string(k) + "]";
    for (const Index v : rows[k]) {
      if (v >= complex.vertexCount()) {
        throw InputError(place, "vertex " + std::to_string(v) + " is out of range");
      }
    }
    try {
      const auto ref = find(rows[k]);
      indices.push_back(ref.index());
      signs.push_back(ref.sign() < 0 ? -1 : 1);
    } catch (const InputError& e) {
      throw InputError(place, e.reason());
    }
  }
  return py::make_tuple(handOver(std::move(indices)), handOver(std::move(signs)));
}

py::array derivative(const Complex& complex, int degree, const py::object& values) {
  if (degree == 3) throw InputError("degree", "3-forms have no derivative");
  return withDegree(degree, [&](auto constant) -> py::array {
    constexpr int K = decltype(constant)::value;
    if constexpr (K < 3) {
      const auto numbers = finiteNumbers(values, "values", complex.count(K));
      Array<double> result(complex.count(K + 1));
      withoutGil([&] {
        if constexpr (K == 0) coboundary0(complex, numbers.data(), result.data());
        if constexpr (K == 1) coboundary1(complex, numbers.data(), result.data());
        if constexpr (K == 2) coboundary2(complex, numbers.data(), result.data());
      });
      return handOver(std::move(result));
    } else {
      return {};
    }
  });
}

/// Unsigned volumes of the cells.
py::array cellVolumes(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  Array<double> volumes(c.cellCount());
  for (Index k = 0; k < c.cellCount(); ++k) {
    volumes[k] = c.cellSigns[k] * cellVolume6(c, mesh.positions(), k) / 6;
  }
  return handOver(std::move(volumes));
}

void bindComplex(py::module_& module) {
  py::class_<Complex, std::shared_ptr<Complex>>(
      module, "Complex", py::module_local(),
      R"(The topology of one level: cells, facets and edges with stored orientation.

A simplex's orientation is the order of its vertices; a coefficient on it changes sign with it.
Cells count as positively oriented, tetrahedra before octahedra. Arrays are read-only views.)")
      .def_property_readonly("vertex_count", &Complex::vertexCount, "Number of vertices.")
      .def_property_readonly("edge_count", &Complex::edgeCount, "Number of edges.")
      .def_property_readonly("facet_count", &Complex::facetCount, "Number of triangles.")
      .def_property_readonly("cell_count", &Complex::cellCount,
                             "Number of tetrahedra and octahedra.")
      .def_property_readonly(
          "edges",
          [](const py::object& self) {
            return viewRows(self.cast<const Complex&>().edges, 2, self);
          },
          "int32 (edges, 2): vertices of the edges. A view.")
      .def_property_readonly("facets", &facetTriples,
                             "int32 (facets, 3): vertices of the facets. Computed at each access.")
      .def_property_readonly(
          "tetrahedra",
          [](const py::object& self) {
            return viewRows(self.cast<const Complex&>().tets, 4, self);
          },
          "int32 (tetrahedra, 4): vertices of the tetrahedra. A view.")
      .def_property_readonly(
          "octahedra",
          [](const py::object& self) {
            return viewRows(self.cast<const Complex&>().octs, 6, self);
          },
          "int32 (octahedra, 6): pole, ring of four, pole. A view.")
      .def_property_readonly(
          "boundary_facets",
          [](const Complex& c) {
            return indicesWhere(c.facetCount(), [&](Index f) { return c.facetOnBoundary(f); });
          },
          "int32 (n,): indices of the facets on the boundary, ascending.")
      .def_property_readonly(
          "boundary_edges",
          [](const Complex& c) {
            return indicesWhere(c.edgeCount(), [&](Index e) { return c.edgeOnBoundary(e); });
          },
          "int32 (n,): indices of the edges on the boundary, ascending.")
      .def_property_readonly(
          "outward_signs",
          [](const Complex& c) {
            Array<std::int8_t> signs(c.facetCount());
            for (Index f = 0; f < c.facetCount(); ++f) {
              const bool outOf = c.facetCells[f][0].exists(), into = c.facetCells[f][1].exists();
              signs[f] = static_cast<std::int8_t>(outOf && into ? 0 : outOf ? 1 : -1);
            }
            return handOver(std::move(signs));
          },
          "int8 (facets,): +1 where a boundary facet's stored orientation points out of the\n"
          "domain, -1 where it points in, 0 inside.")
      .def(
          "count",
          [](const Complex& c, int degree) {
            return withDegree(degree, [&](auto constant) { return c.count(constant); });
          },
          py::arg("degree"), "Number of coefficients of a form: vertices, edges, facets or cells.")
      .def("derivative", &derivative, py::arg("degree"), py::arg("values"),
           R"(Exterior derivative of a form of degree 0, 1 or 2.

values: float64 (count(degree),). Returns float64 (count(degree + 1),).)")
      .def("__repr__", [](const Complex& c) {
        return "<octetvdb.Complex: " + std::to_string(c.vertexCount()) + " vertices, " +
               std::to_string(c.tetCount()) + " tetrahedra, " + std::to_string(c.octCount()) +
               " octahedra>";
      });
}

}  // namespace

void bindMesh(py::module_& module) {
  bindComplex(module);
  py::class_<ControlMesh, std::shared_ptr<ControlMesh>>(
      module, "ControlMesh", py::module_local(),
      R"(A coarse mesh of tetrahedra and octahedra, checked and numbered. Immutable.

vertices:   float (n, 3), world units
tetrahedra: int (n, 4), any orientation
octahedra:  int (n, 6): pole, ring of four, pole
creases:    int (n, 2), sharp boundary edges; None: those sharper than 40 degrees
corners:    int (n,), boundary vertices that stay, beside those where creases end

Edges and facets are numbered in lexicographic order of their sorted vertices and stored ascending.
Raises InputError naming the place ("tetrahedra[3]") and the reason.)")
      .def(py::init(&buildMesh), py::arg("vertices"), py::arg("tetrahedra") = py::none(),
           py::arg("octahedra") = py::none(), py::kw_only(), py::arg("creases") = py::none(),
           py::arg("corners") = py::none())
      .def_property_readonly(
          "vertices",
          [](const py::object& self) {
            return viewRows(self.cast<const ControlMesh&>().positions(), 3, self);
          },
          "float64 (vertices, 3), world units. A view.")
      .def_property_readonly(
          "tetrahedra",
          [](const py::object& self) {
            return viewRows(self.cast<const ControlMesh&>().complex()->tets, 4, self);
          },
          "int32 (tetrahedra, 4). A view.")
      .def_property_readonly(
          "octahedra",
          [](const py::object& self) {
            return viewRows(self.cast<const ControlMesh&>().complex()->octs, 6, self);
          },
          "int32 (octahedra, 6). A view.")
      .def_property_readonly(
          "creases", [](const ControlMesh& mesh) { return creaseEdges(*mesh.complex()); },
          "int32 (n, 2): the sharp boundary edges, given or guessed.")
      .def_property_readonly(
          "corners",
          [](const py::object& self) {
            const auto& corners = self.cast<const ControlMesh&>().corners();
            return view(corners.data(), {static_cast<py::ssize_t>(corners.size())}, self);
          },
          "int32 (n,): boundary vertices given to stay, beside those where creases end. A view.")
      .def_property_readonly(
          "complex",
          [](const ControlMesh& mesh) { return std::const_pointer_cast<Complex>(mesh.complex()); },
          "The mesh's topology.")
      .def_property_readonly("cell_volumes", &cellVolumes,
                             "float64 (cells,): volumes, tetrahedra first.")
      .def(
          "edge_index",
          [](const ControlMesh& mesh, const py::object& edges) {
            return findSimplices<2>(edges, "edges", *mesh.complex(),
                                    [&](const auto& e) { return mesh.edge(e[0], e[1]); });
          },
          py::arg("edges"),
          R"(Where edges stand in the numbering.

edges: int (n, 2), pairs of vertices. Returns int32 (n,) indices, and int8 (n,) signs: +1 where the
pair runs along the stored orientation.)")
      .def(
          "facet_index",
          [](const ControlMesh& mesh, const py::object& facets) {
            return findSimplices<3>(facets, "facets", *mesh.complex(),
                                    [&](const auto& f) { return mesh.facet(f[0], f[1], f[2]); });
          },
          py::arg("facets"),
          R"(Where facets stand in the numbering.

facets: int (n, 3), triples of vertices. Returns int32 (n,) indices, and int8 (n,) signs: +1 where
the triple turns as the stored orientation.)")
      .def("__repr__", [](const ControlMesh& mesh) {
        return "<octetvdb.ControlMesh: " + std::to_string(mesh.positions().size()) + " vertices, " +
               std::to_string(mesh.complex()->tetCount()) + " tetrahedra, " +
               std::to_string(mesh.complex()->octCount()) + " octahedra>";
      });
}

}  // namespace octet::python
