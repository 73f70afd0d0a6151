// SPDX-License-Identifier: Apache-2.0
#include "gmsh_reader.h"

#include <new>
#include <stdexcept>

#include <gmsh.h>

namespace octet::gmsh_import {
namespace {

std::vector<ElementBlock> readElements(int dimension, int entity) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> tags, nodes;
  gmsh::model::mesh::getElements(types, tags, nodes, dimension, entity);
  std::vector<ElementBlock> blocks(types.size());
  for (std::size_t k = 0; k < types.size(); ++k) {
    ElementBlock& block = blocks[k];
    int order = 0, primaryNodes = 0;
    std::vector<double> local;
    block.type = types[k];
    gmsh::model::mesh::getElementProperties(types[k], block.typeName, block.dimension, order,
                                            block.nodesPerElement, local, primaryNodes);
    block.tags.assign(tags[k].begin(), tags[k].end());
    block.nodes.assign(nodes[k].begin(), nodes[k].end());
  }
  return blocks;
}

std::vector<PhysicalGroup> readGroups() {
  std::vector<PhysicalGroup> groups;
  for (const int dimension : {0, 1}) {
    gmsh::vectorpair tags;
    gmsh::model::getPhysicalGroups(tags, dimension);
    for (const auto& [dim, tag] : tags) {
      PhysicalGroup group;
      group.dimension = dim;
      gmsh::model::getPhysicalName(dim, tag, group.name);
      if (group.name.empty()) continue;
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dim, tag, entities);
      for (const int entity : entities) {
        for (ElementBlock& block : readElements(dim, entity)) group.blocks.push_back(block);
      }
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

std::vector<View> readViews() {
  std::vector<int> tags;
  gmsh::view::getTags(tags);
  std::vector<View> views;
  for (const int tag : tags) {
    const std::string option = "View[" + std::to_string(gmsh::view::getIndex(tag)) + "].";
    View view;
    double steps = 0;
    gmsh::option::getString(option + "Name", view.name);
    gmsh::option::getNumber(option + "NbTimeStep", steps);
    for (int step = 0; step < static_cast<int>(steps); ++step) {
      ViewStep s;
      s.step = step;
      std::vector<std::size_t> entries;
      double time = 0;
      gmsh::view::getHomogeneousModelData(tag, step, view.dataType, entries, s.values, time,
                                          s.components);
      if (entries.empty()) continue;  // steps are counted from 0 whether the file has them or not
      s.tags.assign(entries.begin(), entries.end());
      view.steps.push_back(std::move(s));
    }
    views.push_back(std::move(view));
  }
  return views;
}

/// Gmsh's reason, or its last warning where the reason says only that the file cannot be read.
std::string reason(const std::string& error, const std::string& path,
                   const std::vector<std::string>& messages) {
  if (error.find(path) == std::string::npos) return "Gmsh cannot read it: " + error;
  const std::string warning = "Warning: ";
  for (auto m = messages.rbegin(); m != messages.rend(); ++m) {
    if (m->rfind(warning, 0) == 0) return "Gmsh cannot read it: " + m->substr(warning.size());
  }
  return "Gmsh cannot read it: it is malformed or cut off";
}

}  // namespace

GmshMesh readWithGmsh(const std::string& path) {
  GmshMesh mesh;
  std::string error;
  try {
    // Not the user's settings: a mesh is to read the same everywhere.
    gmsh::initialize(0, nullptr, /*readConfigFiles=*/false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::logger::start();
    gmsh::merge(path);
    std::vector<std::size_t> tags;
    std::vector<double> parameters;
    gmsh::model::mesh::getNodes(tags, mesh.coordinates, parameters);
    mesh.nodeTags.assign(tags.begin(), tags.end());
    mesh.blocks = readElements(-1, -1);
    mesh.groups = readGroups();
    mesh.views = readViews();
  } catch (const std::string& e) {  // Gmsh's own kind of exception
    error = e;
  } catch (const std::bad_alloc&) {
    error = "it asks for more memory than a file of its size needs";
  } catch (const std::length_error&) {
    error = "it asks for more memory than a file of its size needs";
  } catch (const std::exception& e) {
    error = e.what();
  }
  gmsh::logger::get(mesh.messages);
  if (!error.empty()) mesh.error = reason(error, path, mesh.messages);
  return mesh;  // no gmsh::finalize: the process ends here, and the model may be damaged
}

}  // namespace octet::gmsh_import
