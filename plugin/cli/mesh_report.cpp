// SPDX-License-Identifier: Apache-2.0
#include "mesh_report.h"

#include <cmath>
#include <iostream>
#include <map>

#include <octet/core/cage/quality.h>
#include <octet/core/refine/interior_moves.h>
#include <octet/core/topology/boundary.h>
#include <octet/core/topology/domain_box.h>

#include "console.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

const char* typeName(VertexType type) {
  constexpr const char* kNames[] = {"R", "X1", "X2", "X3", "B1", "B2", "B3"};
  return kNames[static_cast<int>(type)];
}

/// How often each number occurs.
template <typename Counts>
Json histogram(const Counts& counts) {
  Json result = Json::object();
  for (const auto& [key, n] : counts) result[std::to_string(key)] = n;
  return result;
}

Json describeQuality(const ControlMesh& mesh) {
  const CageQuality q = measureQuality(*mesh.complex(), mesh.positions());
  return {{"dihedral_angles", {q.minDihedral, q.maxDihedral}},
          {"cell_volumes", {q.minVolume, q.maxVolume}},
          {"worst_shape", q.minShape},
          {"components", q.components},
          {"touching_vertices", q.touchingVertices},
          {"touching_edges", q.touchingEdges}};
}

}  // namespace

Json describeMesh(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  std::map<std::string, std::int64_t> types;
  for (const VertexType type : c.vertexTypes) ++types[typeName(type)];
  std::map<int, std::int64_t> edgeValences, boundaryValences;
  std::int64_t creases = 0;
  for (Index e = 0; e < c.edgeCount(); ++e) {
    if (c.edgeFlags[e] & kOnCrease) ++creases;
    if (!c.edgeOnBoundary(e)) ++edgeValences[c.edgeStarBegin[e + 1] - c.edgeStarBegin[e]];
  }
  const Boundary boundary(c, mesh.corners(), nullptr);
  std::int64_t corners = 0;
  for (Index row = 0; row < boundary.vertexCount(); ++row) {
    ++boundaryValences[boundary.valence(row)];
    if (boundary.kinds[row] == BoundaryKind::Corner) ++corners;
  }
  const IrregularStars stars(c);
  std::int64_t folding = 0;
  for (Index v = 0; v < c.vertexCount(); ++v) folding += starFolds(stars, v);
  double volume = 0;
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    volume += std::abs(cellVolume6(c, mesh.positions(), cell)) / 6;
  }
  const Box box = domainBox(c, mesh.positions());
  Json result = {{"vertices", c.vertexCount()},
                 {"edges", c.edgeCount()},
                 {"facets", c.facetCount()},
                 {"tetrahedra", c.tetCount()},
                 {"octahedra", c.octCount()},
                 {"boundary_facets", boundary.facets.size()},
                 {"creases", creases},
                 {"corners", corners},
                 {"vertex_types", types},
                 {"folding_stars", folding},
                 {"interior_edge_valences", histogram(edgeValences)},
                 {"boundary_valences", histogram(boundaryValences)},
                 {"volume", volume},
                 {"box",
                  {std::vector<double>(box.min.begin(), box.min.end()),
                   std::vector<double>(box.max.begin(), box.max.end())}}};
  result["quality"] = describeQuality(mesh);
  return result;
}

void printPlain(const Json& value, const std::string& indent) {
  const auto oneLine = [](const Json& entry) {
    return entry.is_string() ? entry.get<std::string>()
                             : entry.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  for (const auto& [key, entry] : value.items()) {
    if (entry.is_array() && !entry.empty() && entry[0].is_object()) {
      std::cout << indent << key << ":\n";
      for (const Json& element : entry) {
        printPlain(element, indent + "  ");
        std::cout << "\n";
      }
    } else if (entry.is_object()) {
      std::cout << indent << key << ":";
      for (const auto& [name, n] : entry.items()) std::cout << "  " << name << " " << oneLine(n);
      std::cout << "\n";
    } else {
      std::cout << indent << key << ": " << oneLine(entry) << "\n";
    }
  }
}

}  // namespace octet::cli
