// SPDX-License-Identifier: Apache-2.0
// Subdivides a tetrahedron with the installed core and prints the number of cells.
#include <iostream>

#include <octet/core/refine/refiner.h>

int main() {
  octet::ControlMeshInput input;
  input.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  input.tets = {{0, 1, 2, 3}};
  octet::RefinerOptions options;
  options.levels = 2;
  const octet::Refiner refiner(octet::ControlMesh::build(std::move(input)), options);
  std::cout << refiner.finest().cellCount() << "\n";
}
