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

/// What Gmsh found in a mesh file, as plain data. It comes out of a process whose memory a broken
/// file may have spoilt: nothing in it is to be relied on unchecked.
struct GmshMesh {
  std::string error;  ///< why Gmsh cannot read the file
  std::vector<std::string> messages;
  std::vector<Tag> nodeTags;
  std::vector<double> coordinates;
  std::vector<ElementBlock> blocks;
  std::vector<View> views;
  std::vector<PhysicalGroup> groups;  ///< points and curves
};

/// GmshMesh as bytes and back. unpack throws std::runtime_error when they are damaged.
std::string pack(const GmshMesh& mesh);
GmshMesh unpack(const std::string& bytes);

}  // namespace octet::gmsh_import
