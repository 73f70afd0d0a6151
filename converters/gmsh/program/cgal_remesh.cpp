// SPDX-License-Identifier: Apache-2.0
#include "cgal_remesh.h"

#include <algorithm>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Surface_mesh.h>

#include <octet/core/base/error.h>

namespace octet::gmsh_import {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
namespace parameters = CGAL::parameters;

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Vertex = Mesh::Vertex_index;
using Edge = Mesh::Edge_index;

/// Of 5 and 10 rounds with 1, 2, 3 and 5 steps each, those with the best dihedral angles of
/// tetrahedra: 19 to 145 degrees in ten bodies.
constexpr int kRounds = 10;
constexpr unsigned kRelaxationSteps = 2;

/// Slivers are triangles with a longest edge of more than this times the shortest, or with an angle
/// of more than 180 degrees less about 4 / this, in radians, here as its cosine.
constexpr double kNeedle = 1e6;
constexpr double kCap = -1 + 8 / (kNeedle * kNeedle);

Vec3 vec(const Point& p) { return Vec3(p.x(), p.y(), p.z()); }
Point point(const Vec3& p) { return Point(p[0], p[1], p[2]); }

/// Refuses edges with more than two triangles, and notes the vertices that CGAL duplicates.
struct Orientation : pmp::Default_orientation_visitor {
  std::vector<Index>* original;  // of each duplicate

  void non_manifold_edge(std::size_t a, std::size_t b, std::size_t triangles) {
    throw InputError("vertices[" + std::to_string(a) + "]",
                     "edge (" + std::to_string(a) + "," + std::to_string(b) + ") has " +
                         std::to_string(triangles) + " instead of two triangles");
  }
  void duplicated_vertex(std::size_t v, std::size_t) { original->push_back(static_cast<Index>(v)); }
};

/// Vertices and their order are the surface's, whether triangles use them or not.
Mesh meshOf(const TriangleSurface& surface) {
  Mesh mesh;
  for (const Vec3& p : surface.vertices) mesh.add_vertex(point(p));
  for (const auto& [a, b, c] : surface.triangles) mesh.add_face(Vertex(a), Vertex(b), Vertex(c));
  return mesh;
}

/// New numbers of the vertices that triangles use, by old ones.
std::vector<Index> numbersIn(const Mesh& mesh) {
  std::vector<Index> numbers(mesh.num_vertices(), kNone);
  Index count = 0;
  for (const Vertex v : mesh.vertices()) {
    if (!mesh.is_isolated(v)) numbers[v] = count++;
  }
  return numbers;
}

TriangleSurface surfaceOf(const Mesh& mesh, const std::vector<Index>& numbers) {
  TriangleSurface surface;
  for (const Vertex v : mesh.vertices()) {
    if (!mesh.is_isolated(v)) surface.vertices.push_back(vec(mesh.point(v)));
  }
  for (const auto f : mesh.faces()) {
    auto& triangle = surface.triangles.emplace_back();
    int k = 0;
    for (const Vertex v : mesh.vertices_around_face(mesh.halfedge(f))) triangle[k++] = numbers[v];
  }
  return surface;
}

class Remesher {
 public:
  Remesher(const TriangleSurface& surface, const RemeshOptions& options)
      : options_(options),
        given_(orientedByCgal(surface)),
        sharp_(findSharpEdges(given_, options.sharpAngle, kLeastSharp * options.edgeLength)),
        closest_(given_),
        chainSurfaces_(chainsAsSurfaces(given_, sharp_)),
        closestOnChain_(chainSurfaces_.begin(), chainSurfaces_.end()),
        mesh_(meshOf(given_)),
        chains_(mesh_.add_property_map<Edge, Index>("e:chain", 0).first),
        isCorner_(mesh_.add_property_map<Vertex, bool>("v:corner", false).first) {
    for (std::size_t e = 0; e < sharp_.edges.size(); ++e) {
      const auto& [a, b] = sharp_.edges[e];
      chains_[mesh_.edge(mesh_.halfedge(Vertex(a), Vertex(b)))] = sharp_.chains[e] + 1;
    }
    for (const Index v : sharp_.corners) isCorner_[Vertex(v)] = true;
  }

  RemeshedSurface run(const Context& context) {
    for (int round = 0; round < kRounds; ++round) {
      context.report({"remesh surface", static_cast<std::size_t>(round),
                      static_cast<std::size_t>(kRounds), "rounds"});
      const auto onSurface = [this](Vertex v) {
        return point(closest_.find(vec(mesh_.point(v))).position);
      };
      pmp::isotropic_remeshing(mesh_.faces(), options_.edgeLength, mesh_,
                               parameters::edge_is_constrained_map(chains_)
                                   .vertex_is_constrained_map(isCorner_)
                                   .relax_constraints(true)
                                   .number_of_relaxation_steps(kRelaxationSteps)
                                   .projection_functor(onSurface));
      backToSharpEdges();
    }
    return result();
  }

 private:
  /// CGAL moves vertices of constrained edges along chords, and corners where two of these meet.
  void backToSharpEdges() {
    for (const Edge e : mesh_.edges()) {
      if (chains_[e] == 0) continue;
      for (const Vertex v : {mesh_.vertex(e, 0), mesh_.vertex(e, 1)}) {
        if (isCorner_[v]) continue;
        Point& p = mesh_.point(v);
        p = point(closestOnChain_[chains_[e] - 1].find(vec(p)).position);
      }
    }
    for (const Index v : sharp_.corners) mesh_.point(Vertex(v)) = point(given_.vertices[v]);
  }

  RemeshedSurface result() {
    mesh_.collect_garbage();
    const std::vector<Index> numbers = numbersIn(mesh_);
    RemeshedSurface result;
    result.surface = surfaceOf(mesh_, numbers);
    for (const Edge e : mesh_.edges()) {
      if (chains_[e] == 0) continue;
      const auto [a, b] = std::minmax(numbers[mesh_.vertex(e, 0)], numbers[mesh_.vertex(e, 1)]);
      result.creases.push_back({a, b});
    }
    std::sort(result.creases.begin(), result.creases.end());
    for (const Vertex v : mesh_.vertices()) {
      if (isCorner_[v]) result.corners.push_back(numbers[v]);
    }
    return result;
  }

  const RemeshOptions& options_;
  const TriangleSurface given_;
  const SharpEdges sharp_;
  const ClosestPoints closest_;
  const std::vector<TriangleSurface> chainSurfaces_;
  const std::vector<ClosestPoints> closestOnChain_;
  Mesh mesh_;
  /// Number of each edge's chain, counted from 1. To CGAL the edges that have one are constrained;
  /// it copies what it finds here to both halves of an edge that it splits.
  Mesh::Property_map<Edge, Index> chains_;
  Mesh::Property_map<Vertex, bool> isCorner_;
};

}  // namespace

TriangleSurface orientedByCgal(const TriangleSurface& surface) {
  checkClosed(surface);
  std::vector<Index> original;
  Orientation visitor;
  visitor.original = &original;
  TriangleSurface result = surface;
  pmp::orient_polygon_soup(result.vertices, result.triangles, parameters::visitor(visitor));
  if (original.empty()) return result;
  const std::string place = "vertices[" + std::to_string(original.front()) + "]";
  if (CGAL::is_closed(meshOf(result))) throw InputError(place, "the surface touches itself here");
  throw InputError(place, "the surface is one-sided");
}

RemeshedSurface remeshByCgal(const TriangleSurface& surface, const RemeshOptions& options,
                             const Context& context) {
  return Remesher(surface, options).run(context);
}

TriangleSurface withoutSliversByCgal(const TriangleSurface& surface) {
  Mesh mesh = meshOf(orientedByCgal(surface));
#if CGAL_VERSION_NR >= CGAL_VERSION_NUMBER(5, 6, 0)
  pmp::remove_almost_degenerate_faces(mesh,
                                      parameters::cap_threshold(kCap).needle_threshold(kNeedle));
#else
  pmp::experimental::remove_almost_degenerate_faces(mesh, kCap, kNeedle, 0);
#endif
  mesh.collect_garbage();
  return surfaceOf(mesh, numbersIn(mesh));
}

}  // namespace octet::gmsh_import
