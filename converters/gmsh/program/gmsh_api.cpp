// SPDX-License-Identifier: Apache-2.0
#include "gmsh_api.h"

#include <type_traits>

#include <gmshc.h>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

namespace octet::gmsh_import {
namespace {

/// An array that Gmsh returns. It is not freed: the process is Gmsh's alone, and short-lived.
template <typename T>
struct List {
  T* data = nullptr;
  std::size_t size = 0;

  std::vector<T> take() const {
    return size ? std::vector<T>(data, data + size) : std::vector<T>();
  }
};

/// An array of arrays that Gmsh returns.
template <typename T>
struct Lists {
  T** data = nullptr;
  std::size_t* sizes = nullptr;
  std::size_t size = 0;

  std::vector<std::vector<T>> take() const {
    std::vector<std::vector<T>> result;
    for (std::size_t k = 0; k < size; ++k) result.push_back(List<T>{data[k], sizes[k]}.take());
    return result;
  }
};

/// Dimension of a surface, and the tag that lets Gmsh choose one.
constexpr int kSurface = 2, kNextTag = -1;

std::string take(const char* text) { return text ? text : ""; }

}  // namespace

// Calls a function of the C API, all of which take a place for an error code at the end.
#define OCTET_GMSH(function, ...) call<decltype(function)>(#function, __VA_ARGS__)

template <typename Function, typename... Arguments>
auto GmshApi::call(const char* name, Arguments... arguments) {
  const auto function = reinterpret_cast<Function*>(system::functionOf(library_, name));
  if (!function) throw IoError("the Gmsh library", std::string("has no function ") + name);
  int error = 0;
  const auto check = [&] {
    if (error == 0) return;
    const auto lastError = reinterpret_cast<decltype(gmshLoggerGetLastError)*>(
        system::functionOf(library_, "gmshLoggerGetLastError"));
    char* reason = nullptr;
    int ignored = 0;
    if (lastError) lastError(&reason, &ignored);
    throw Error("", "", take(reason));
  };
  using Result = std::invoke_result_t<Function*, Arguments..., int*>;
  if constexpr (std::is_void_v<Result>) {
    function(arguments..., &error);
    check();
  } else {
    const Result result = function(arguments..., &error);
    check();
    return result;
  }
}

GmshApi::GmshApi() {
  for (const char* name : {OCTET_GMSH_LIBRARY, OCTET_GMSH_LIBRARY_NAME, "libgmsh.so"}) {
    library_ = system::loadLibrary(name);
    if (library_) return;
  }
  throw IoError("the Gmsh library", "cannot be loaded: " + system::loadError());
}

void GmshApi::initialize() {
  const auto start = [this](auto* function) {
    using Function = std::remove_pointer_t<decltype(function)>;
    if constexpr (std::is_invocable_v<Function*, int, char**, int, int*>) {
      call<Function>("gmshInitialize", 0, nullptr, /*readConfigFiles=*/0);
    } else {  // later than 4.8, as in Ubuntu
      call<Function>("gmshInitialize", 0, nullptr, /*readConfigFiles=*/0, /*run=*/0);
    }
  };
  start(static_cast<decltype(gmshInitialize)*>(nullptr));
  setOption("General.Terminal", 0);
  call<decltype(gmshLoggerStart)>("gmshLoggerStart");
}

void GmshApi::merge(const std::string& path) { OCTET_GMSH(gmshMerge, path.c_str()); }

std::vector<std::string> GmshApi::messages() {
  List<char*> list;
  OCTET_GMSH(gmshLoggerGet, &list.data, &list.size);
  std::vector<std::string> result;
  for (const char* message : list.take()) result.push_back(take(message));
  return result;
}

GmshApi::Nodes GmshApi::nodes() {
  List<std::size_t> tags;
  List<double> coordinates, parameters;
  OCTET_GMSH(gmshModelMeshGetNodes, &tags.data, &tags.size, &coordinates.data, &coordinates.size,
             &parameters.data, &parameters.size, -1, -1, /*includeBoundary=*/0,
             /*returnParametricCoord=*/0);
  return {tags.take(), coordinates.take()};
}

GmshApi::Elements GmshApi::elements(int dimension, int entity) {
  List<int> types;
  Lists<std::size_t> tags, nodes;
  OCTET_GMSH(gmshModelMeshGetElements, &types.data, &types.size, &tags.data, &tags.sizes,
             &tags.size, &nodes.data, &nodes.sizes, &nodes.size, dimension, entity);
  return {types.take(), tags.take(), nodes.take()};
}

GmshApi::ElementType GmshApi::elementType(int type) {
  ElementType result;
  char* name = nullptr;
  int order = 0, primaryNodes = 0;
  List<double> local;
  OCTET_GMSH(gmshModelMeshGetElementProperties, type, &name, &result.dimension, &order,
             &result.nodes, &local.data, &local.size, &primaryNodes);
  result.name = take(name);
  return result;
}

std::vector<int> GmshApi::physicalGroups(int dimension) {
  List<int> pairs;
  OCTET_GMSH(gmshModelGetPhysicalGroups, &pairs.data, &pairs.size, dimension);
  std::vector<int> tags;
  for (std::size_t k = 1; k < pairs.size; k += 2) tags.push_back(pairs.data[k]);
  return tags;
}

std::string GmshApi::physicalName(int dimension, int group) {
  char* name = nullptr;
  OCTET_GMSH(gmshModelGetPhysicalName, dimension, group, &name);
  return take(name);
}

std::vector<int> GmshApi::entitiesOfGroup(int dimension, int group) {
  List<int> tags;
  OCTET_GMSH(gmshModelGetEntitiesForPhysicalGroup, dimension, group, &tags.data, &tags.size);
  return tags.take();
}

std::vector<int> GmshApi::views() {
  List<int> tags;
  OCTET_GMSH(gmshViewGetTags, &tags.data, &tags.size);
  return tags.take();
}

std::string GmshApi::viewName(int view) {
  const std::string option =
      "View[" + std::to_string(OCTET_GMSH(gmshViewGetIndex, view)) + "].Name";
  char* name = nullptr;
  OCTET_GMSH(gmshOptionGetString, option.c_str(), &name);
  return take(name);
}

int GmshApi::viewSteps(int view) {
  const std::string option =
      "View[" + std::to_string(OCTET_GMSH(gmshViewGetIndex, view)) + "].NbTimeStep";
  double steps = 0;
  OCTET_GMSH(gmshOptionGetNumber, option.c_str(), &steps);
  return static_cast<int>(steps);
}

GmshApi::ViewData GmshApi::viewData(int view, int step) {
  ViewData result;
  char* type = nullptr;
  List<std::size_t> tags;
  List<double> values;
  double time = 0;
  OCTET_GMSH(gmshViewGetHomogeneousModelData, view, step, &type, &tags.data, &tags.size,
             &values.data, &values.size, &time, &result.components);
  result.type = take(type);
  result.tags = tags.take();
  result.values = values.take();
  return result;
}

void GmshApi::setOption(const std::string& name, double value) {
  OCTET_GMSH(gmshOptionSetNumber, name.c_str(), value);
}

int GmshApi::addSurface() {
  return OCTET_GMSH(gmshModelAddDiscreteEntity, kSurface, kNextTag, nullptr, std::size_t{0});
}

void GmshApi::addNodes(int surface, std::vector<double> coordinates) {
  std::vector<std::size_t> tags(coordinates.size() / 3);
  for (std::size_t k = 0; k < tags.size(); ++k) tags[k] = k + 1;
  OCTET_GMSH(gmshModelMeshAddNodes, kSurface, surface, tags.data(), tags.size(), coordinates.data(),
             coordinates.size(), nullptr, std::size_t{0});
}

void GmshApi::addTriangles(int surface, std::vector<std::size_t> nodes) {
  constexpr int kTriangle = 2;
  OCTET_GMSH(gmshModelMeshAddElementsByType, surface, kTriangle, nullptr, std::size_t{0},
             nodes.data(), nodes.size());
}

void GmshApi::addVolume(const std::vector<int>& surfaces) {
  std::vector<int> loops;
  for (int surface : surfaces) {
    loops.push_back(OCTET_GMSH(gmshModelGeoAddSurfaceLoop, &surface, std::size_t{1}, kNextTag));
  }
  OCTET_GMSH(gmshModelGeoAddVolume, loops.data(), loops.size(), kNextTag);
}

void GmshApi::generateVolumes() {
  call<decltype(gmshModelGeoSynchronize)>("gmshModelGeoSynchronize");
  OCTET_GMSH(gmshModelMeshGenerate, 3);
}

}  // namespace octet::gmsh_import
