// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace octet::gmsh_import {

/// @brief The part of Gmsh's C API that reading and making a mesh takes, as C++.
///
/// The library is loaded here, and not linked, because it brings some 80 others along (OpenCASCADE,
/// X11): starting a program linked to it takes 0.15 s, six times as long as without.
/// Every function throws Gmsh's message as the reason of an Error when Gmsh reports one. Not thread
/// safe.
class GmshApi {
 public:
  /// @throws IoError when the library cannot be loaded.
  GmshApi();

  /// Without the user's settings, silent, and with a record of messages.
  void initialize();
  void merge(const std::string& path);
  std::vector<std::string> messages();

  struct Nodes {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates;
  };
  Nodes nodes();

  struct Elements {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> tags, nodes;  ///< by type
  };
  /// Of one entity; -1, -1: all.
  Elements elements(int dimension, int entity);

  struct ElementType {
    std::string name;
    int dimension = 0, nodes = 0;
  };
  ElementType elementType(int type);

  std::vector<int> physicalGroups(int dimension);
  std::string physicalName(int dimension, int group);
  std::vector<int> entitiesOfGroup(int dimension, int group);

  /// By tag.
  std::vector<int> views();
  std::string viewName(int view);
  int viewSteps(int view);

  struct ViewData {
    std::string type;
    std::vector<std::size_t> tags;
    std::vector<double> values;
    int components = 0;
  };
  ViewData viewData(int view, int step);

  void setOption(const std::string& name, double value);
  /// A surface of triangles; nodes belong to the first one and count from 1.
  int addSurface();
  void addNodes(int surface, std::vector<double> coordinates);
  void addTriangles(int surface, std::vector<std::size_t> nodes);
  /// The volume within the first of some surfaces and outside of the others.
  void addVolume(const std::vector<int>& surfaces);
  /// Meshes all volumes; surfaces keep their triangles.
  void generateVolumes();

 private:
  template <typename Function, typename... Arguments>
  auto call(const char* name, Arguments... arguments);

  void* library_ = nullptr;  // for as long as the process lives
};

}  // namespace octet::gmsh_import
