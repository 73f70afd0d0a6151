// SPDX-License-Identifier: Apache-2.0
// A cage, a number on each edge, and its exterior derivative: a flow that is exactly
// incompressible.
#include <cstdio>

#include <octet/core/api.h>

int main() {
  // An octahedron and a tetrahedron on one of its facets, in world units.
  octet::ControlMeshInput input;
  input.vertices = {{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {1, -1, 0}, {1, 0, 1}, {1, 0, -1}, {2, 1, 1}};
  input.octs = {{0, 2, 4, 3, 5, 1}};  // pole, ring of four, pole
  input.tets = {{1, 2, 4, 6}};
  const octet::ControlMesh mesh = octet::ControlMesh::build(std::move(input));
  const octet::Complex& complex = *mesh.complex();
  std::printf("%d vertices, %d edges, %d facets, %d cells\n", complex.vertexCount(),
              complex.edgeCount(), complex.facetCount(), complex.cellCount());

  // A vector potential: circulations along edges. Its derivative: fluxes through facets.
  octet::Cochain<1> potential(complex);
  const octet::EdgeRef edge = mesh.edge(0, 2);
  potential[edge.index()] = edge.sign() * 0.5;
  const octet::Cochain<2> flux = octet::d(complex, potential);
  for (octet::Index f = 0; f < complex.facetCount(); ++f) {
    if (flux[f] != 0) std::printf("flux %+.1f through facet %d\n", flux[f], f);
  }
  // The derivative of a derivative: what leaves each cell.
  std::printf("largest divergence %g\n", octet::maxNorm(octet::d(complex, flux).values()));
}
