// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace octet::gmsh_import {

using Tag = std::uint64_t;

/// Elements of one Gmsh type, with the tags of their nodes one element after the other.
struct ElementBlock {
  int type = 0;
  int dimension = 0;
  int nodesPerElement = 0;
  std::string typeName;  ///< as Gmsh calls it: "Tetrahedron 10"
  std::vector<Tag> tags;
  std::vector<Tag> nodes;
};

/// A view's data at one time step.
struct ViewStep {
  int step = 0;
  int components = 0;  ///< numbers per entry, padded
  std::vector<Tag> tags;
  std::vector<double> values;
};

struct View {
  std::string name;
  std::string dataType;  ///< "NodeData", "ElementData", "ElementNodeData", ...
  std::vector<ViewStep> steps;
};

struct PhysicalGroup {
  int dimension = 0;
  std::string name;
  std::vector<ElementBlock> blocks;
};

/// What Gmsh found in a mesh file or made, as plain data. It comes out of a process whose memory a
/// broken file may have spoilt: nothing in it is to be relied on unchecked.
struct GmshMesh {
  std::vector<std::string> messages;
  std::vector<Tag> nodeTags;
  std::vector<double> coordinates;
  std::vector<ElementBlock> blocks;
  std::vector<View> views;
  std::vector<PhysicalGroup> groups;  ///< points and curves
};

/// Closed surfaces of triangles, and the volumes that they bound.
struct GmshShells {
  std::vector<double> coordinates;               ///< of all nodes; node k has the tag k + 1
  std::vector<std::vector<std::size_t>> shells;  ///< tags of the triangles' nodes, by shell
  /// Shells of each volume: the one around it, then those of its cavities.
  std::vector<std::vector<std::size_t>> volumes;
  double edgeLength = 0;  ///< wanted inside
};

}  // namespace octet::gmsh_import
