// SPDX-License-Identifier: Apache-2.0
#include "gmsh_reader.h"

#include <new>

#include <octet/core/base/error.h>

#include "gmsh_api.h"

namespace octet::gmsh_import {
namespace {

std::vector<ElementBlock> readElements(GmshApi* gmsh, int dimension, int entity) {
  const GmshApi::Elements elements = gmsh->elements(dimension, entity);
  std::vector<ElementBlock> blocks(elements.types.size());
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    ElementBlock& block = blocks[k];
    const GmshApi::ElementType type = gmsh->elementType(elements.types[k]);
    block.type = elements.types[k];
    block.typeName = type.name;
    block.dimension = type.dimension;
    block.nodesPerElement = type.nodes;
    block.tags.assign(elements.tags[k].begin(), elements.tags[k].end());
    block.nodes.assign(elements.nodes[k].begin(), elements.nodes[k].end());
  }
  return blocks;
}

std::vector<PhysicalGroup> readGroups(GmshApi* gmsh) {
  std::vector<PhysicalGroup> groups;
  for (const int dimension : {0, 1}) {
    for (const int tag : gmsh->physicalGroups(dimension)) {
      PhysicalGroup group;
      group.dimension = dimension;
      group.name = gmsh->physicalName(dimension, tag);
      if (group.name.empty()) continue;
      for (const int entity : gmsh->entitiesOfGroup(dimension, tag)) {
        for (ElementBlock& block : readElements(gmsh, dimension, entity)) {
          group.blocks.push_back(std::move(block));
        }
      }
      groups.push_back(std::move(group));
    }
  }
  return groups;
}

std::vector<View> readViews(GmshApi* gmsh) {
  std::vector<View> views;
  for (const int tag : gmsh->views()) {
    View view;
    view.name = gmsh->viewName(tag);
    const int steps = gmsh->viewSteps(tag);
    for (int step = 0; step < steps; ++step) {
      GmshApi::ViewData data = gmsh->viewData(tag, step);
      view.dataType = data.type;
      if (data.tags.empty()) continue;  // steps count from 0 whether the file has them or not
      ViewStep s;
      s.step = step;
      s.components = data.components;
      s.tags.assign(data.tags.begin(), data.tags.end());
      s.values = std::move(data.values);
      view.steps.push_back(std::move(s));
    }
    views.push_back(std::move(view));
  }
  return views;
}

/// All of the mesh that GmshMesh holds, but for the messages.
GmshMesh read(const std::string& path, GmshApi* gmsh) {
  GmshMesh mesh;
  gmsh->merge(path);
  const GmshApi::Nodes nodes = gmsh->nodes();
  mesh.nodeTags.assign(nodes.tags.begin(), nodes.tags.end());
  mesh.coordinates = nodes.coordinates;
  mesh.blocks = readElements(gmsh, -1, -1);
  mesh.groups = readGroups(gmsh);
  mesh.views = readViews(gmsh);
  return mesh;
}

/// Gmsh's reason, or its last warning where the reason says only that the file cannot be read.
std::string reason(const std::string& error, const std::string& path,
                   const std::vector<std::string>& messages) {
  if (!error.empty() && error.find(path) == std::string::npos)
    return "Gmsh cannot read it: " + error;
  const std::string warning = "Warning: ";
  for (auto m = messages.rbegin(); m != messages.rend(); ++m) {
    if (m->rfind(warning, 0) == 0) return "Gmsh cannot read it: " + m->substr(warning.size());
  }
  return "Gmsh cannot read it: it is malformed or cut off";
}

}  // namespace

GmshMesh readWithGmsh(const std::string& path) {
  GmshApi gmsh;
  gmsh.initialize();
  std::string error;
  try {
    GmshMesh mesh = read(path, &gmsh);
    mesh.messages = gmsh.messages();
    return mesh;  // no gmshFinalize: the process ends here, and the model may be damaged
  } catch (const IoError&) {  // the library's, not Gmsh's
    throw;
  } catch (const Error& e) {
    error = e.reason();
  } catch (const std::bad_alloc&) {
    error = "it asks for more memory than a file of its size needs";
  }
  throw InputError("", reason(error, path, gmsh.messages()));
}

}  // namespace octet::gmsh_import
