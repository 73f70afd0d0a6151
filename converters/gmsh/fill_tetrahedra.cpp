// SPDX-License-Identifier: Apache-2.0
#include "fill_tetrahedra.h"

#include <algorithm>
#include <cmath>

#include <octet/core/base/error.h>
#include <octet/core/base/reported_loop.h>
#include <octet/core/cage/nesting.h>

#include "gmsh_program.h"
#include "remesh.h"

namespace octet {
namespace {

using namespace gmsh_import;

/// A surface whose edges' lengths are within these, in spacings, and on average within those, is
/// taken as it is.
constexpr double kShortEdge = 0.5, kLongEdge = 1.6, kShortMean = 0.8, kLongMean = 1.25;
/// And whose triangles are at least this high, of their longest edge.
constexpr double kFlatTriangle = 0.2;
/// A remeshed body with less than this of its volume is too small for the spacing.
constexpr double kLeastVolume = 0.5;
/// Volume of the regular tetrahedron with edges of length 1, and area of the triangle.
constexpr double kTetVolume = 0.11785113019775793, kTriangleArea = 0.43301270189221933;

double edgeLength(const TriangleSurface& s, const std::array<Index, 2>& edge) {
  return (s.vertices[edge[1]] - s.vertices[edge[0]]).norm();
}

double lengthOf(const TriangleSurface& s, const std::vector<std::array<Index, 2>>& edges) {
  double sum = 0;
  for (const auto& edge : edges) sum += edgeLength(s, edge);
  return sum;
}

double area(const TriangleSurface& s, const std::array<Index, 3>& t) {
  return (s.vertices[t[1]] - s.vertices[t[0]]).cross(s.vertices[t[2]] - s.vertices[t[0]]).norm() /
         2;
}

/// Are the triangles about as large as wanted?
bool suits(const TriangleSurface& s, double spacing) {
  double sum = 0;
  for (const auto& t : s.triangles) {
    double shortest = HUGE_VAL, longest = 0;
    for (int k = 0; k < 3; ++k) {
      const double length = edgeLength(s, {t[k], t[(k + 1) % 3]});
      shortest = std::min(shortest, length);
      longest = std::max(longest, length);
      sum += length;
    }
    if (shortest < kShortEdge * spacing || longest > kLongEdge * spacing ||
        2 * area(s, t) < kFlatTriangle * longest * longest) {
      return false;
    }
  }
  const double mean = sum / (3 * static_cast<double>(s.triangles.size()));
  return mean >= kShortMean * spacing && mean <= kLongMean * spacing;
}

/// Bodies less cavities.
double volumeOf(const std::vector<SurfacePart>& parts) {
  double volume = 0;
  for (const SurfacePart& part : parts) volume += part.depth % 2 ? -part.volume : part.volume;
  return volume;
}

std::string place(const char* list, Index k) {
  return std::string(list) + "[" + std::to_string(k) + "]";
}

class TetrahedraFill {
 public:
  TetrahedraFill(const TriangleSurface& surface, const TetrahedraOptions& options,
                 const Context& context)
      : given_(surface), options_(options), context_(context) {}

  ControlMesh run(TetrahedraReport* report) {
    check();
    chooseBoundary();
    const ControlMesh mesh = build(meshVolumes());
    checkBoundary(mesh);
    report_.surfaceDistance = distance();
    if (report) *report = report_;
    return mesh;
  }

 private:
  // ---- the surface given ------------------------------------------------------------------------

  void check() {
    if (!(options_.spacing > 0) || !std::isfinite(options_.spacing)) {
      throw InputError("spacing", "is not a positive number");
    }
    if (!(options_.sharpAngle > 0 && options_.sharpAngle <= 180)) {
      throw InputError("sharp-angle", "is not between 0 and 180");
    }
    context_.report({"check surface", 0, 1, "surface"});
    checkClosed(given_);
    given_ = welded(given_);
    if (given_.triangles.empty()) throw InputError("", "the surface has no triangles");
    checkSize();
    if (const auto crossing = findSelfIntersection(given_)) {
      throw InputError(
          place("triangles", crossing->triangle),
          "the surface intersects itself: meets " + place("triangles", crossing->other));
    }
    if (!options_.keepTriangles) given_ = withoutSlivers(given_, context_);
    const std::vector<SurfacePart> parts = surfaceParts(given_);
    report_.bodyVolume = volumeOf(parts);
    for (const SurfacePart& part : parts) ++(part.depth % 2 ? report_.cavities : report_.bodies);
    const double h = options_.spacing;
    checkCount(report_.bodyVolume / (kTetVolume * h * h * h));
  }

  /// Before the surface is searched.
  void checkSize() const {
    double sum = 0;
    for (const auto& t : given_.triangles) sum += area(given_, t);
    const double h = options_.spacing;
    checkCount(options_.keepTriangles ? static_cast<double>(given_.triangles.size())
                                      : sum / (kTriangleArea * h * h));
  }

  static void checkCount(double cells) {
    if (cells < static_cast<double>(kMostTetrahedra)) return;
    throw InputError("spacing",
                     "is too fine: it makes some " +
                         std::to_string(static_cast<std::int64_t>(std::min(cells, 9e18))) +
                         " tetrahedra, at most " + std::to_string(kMostTetrahedra) +
                         " are asked of Gmsh");
  }

  // ---- the boundary -----------------------------------------------------------------------------

  void chooseBoundary() {
    const SharpEdges sharp =
        findSharpEdges(given_, options_.sharpAngle, kLeastSharp * options_.spacing);
    report_.sharpLength = lengthOf(given_, sharp.edges);
    report_.remeshed = !options_.keepTriangles && !suits(given_, options_.spacing);
    if (report_.remeshed) {
      RemeshOptions remeshing;
      remeshing.edgeLength = options_.spacing;
      remeshing.sharpAngle = options_.sharpAngle;
      boundary_ = remesh(given_, remeshing, context_.sub(0.4));
    } else {
      boundary_ = {oriented(given_, context_), sharp.edges, sharp.corners};
    }
    report_.creaseLength = lengthOf(boundary_.surface, boundary_.creases);
    parts_ = surfaceParts(boundary_.surface);
    if (report_.remeshed) checkRemeshed();
  }

  void checkRemeshed() const {
    const double volume = volumeOf(parts_);
    if (volume < kLeastVolume * report_.bodyVolume) {
      throw InputError("spacing",
                       "is too coarse: with edges of that length the body has a volume of " +
                           std::to_string(volume) + " instead of " +
                           std::to_string(report_.bodyVolume));
    }
    const auto crossing = findSelfIntersection(boundary_.surface);
    if (!crossing) return;
    const Vec3& p = boundary_.surface.vertices[boundary_.surface.triangles[crossing->triangle][0]];
    throw InputError("spacing",
                     "is too coarse: triangles of that size would pass through each "
                     "other near (" +
                         std::to_string(p[0]) + ", " + std::to_string(p[1]) + ", " +
                         std::to_string(p[2]) + ")");
  }

  // ---- Gmsh -------------------------------------------------------------------------------------

  GmshShells shells() const {
    GmshShells in;
    in.edgeLength = options_.spacing;
    for (const Vec3& p : boundary_.surface.vertices) {
      in.coordinates.insert(in.coordinates.end(), p.begin(), p.end());
    }
    std::vector<std::size_t> volumeOfPart(parts_.size());
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      auto& nodes = in.shells.emplace_back();
      for (const Index t : parts_[k].triangles) {
        for (const Index v : boundary_.surface.triangles[t]) {
          nodes.push_back(static_cast<std::size_t>(v) + 1);
        }
      }
      if (parts_[k].depth % 2) continue;
      volumeOfPart[k] = in.volumes.size();
      in.volumes.push_back({k});
    }
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      if (parts_[k].depth % 2) {
        in.volumes[volumeOfPart[static_cast<std::size_t>(parts_[k].parent)]].push_back(k);
      }
    }
    return in;
  }

  GmshMesh meshVolumes() const {
    const double h = options_.spacing;
    const auto cells = static_cast<std::uint64_t>(report_.bodyVolume / (kTetVolume * h * h * h)) +
                       20 * boundary_.surface.triangles.size();
    GmshWork work;
    work.request = MessageKind::FillMesh;
    work.who = "Gmsh";
    work.doing = "meshing it";
    // Generous: Gmsh takes some 1 kB and 0.1 ms a tetrahedron.
    work.mostBytes = kLeastMemory + 10'000 * cells;
    work.time = kLeastTime + std::chrono::milliseconds(cells);
    work.report = {"mesh with Gmsh", 0, 0, "tetrahedra"};
    work.content = pack(FillRequest{shells(), work.mostBytes});
    return askGmsh<GmshMesh>(work, context_);
  }

  /// Vertices of the boundary come first, then Gmsh's in the order of their tags.
  ControlMesh build(const GmshMesh& mesh) const {
    const std::size_t onBoundary = boundary_.surface.vertices.size();
    std::vector<Tag> inner;
    for (const Tag tag : mesh.nodeTags) {
      if (tag > onBoundary) inner.push_back(tag);
    }
    std::sort(inner.begin(), inner.end());
    const auto number = [&](Tag tag) {
      if (tag >= 1 && tag <= onBoundary) return static_cast<Index>(tag) - 1;
      const auto found = std::lower_bound(inner.begin(), inner.end(), tag);
      if (found == inner.end() || *found != tag) {
        throw InputError("", "Gmsh failed: it made a tetrahedron without such a node");
      }
      return static_cast<Index>(onBoundary) + static_cast<Index>(found - inner.begin());
    };
    ControlMeshInput input;
    input.vertices = boundary_.surface.vertices;
    input.vertices.resize(onBoundary + inner.size());
    if (mesh.coordinates.size() != 3 * mesh.nodeTags.size()) throw InputError("", "Gmsh failed");
    for (std::size_t k = 0; k < mesh.nodeTags.size(); ++k) {
      if (mesh.nodeTags[k] <= onBoundary) continue;
      const double* x = &mesh.coordinates[3 * k];
      input.vertices[number(mesh.nodeTags[k])] = Vec3(x[0], x[1], x[2]);
    }
    for (const ElementBlock& block : mesh.blocks) {
      for (std::size_t k = 0; k + 3 < block.nodes.size(); k += 4) {
        auto& cell = input.tets.emplace_back();
        for (std::size_t i = 0; i < 4; ++i) cell[i] = number(block.nodes[k + i]);
      }
    }
    if (input.tets.empty()) throw InputError("", "Gmsh made no tetrahedra in it");
    dropUnused(onBoundary, &input);
    input.creases = boundary_.creases;
    input.corners = boundary_.corners;
    return ControlMesh::build(std::move(input), context_);
  }

  /// Drops vertices inside that no tetrahedron has.
  static void dropUnused(std::size_t onBoundary, ControlMeshInput* input) {
    std::vector<Index> number(input->vertices.size(), kNone);
    for (std::size_t v = 0; v < onBoundary; ++v) number[v] = 0;
    for (const auto& cell : input->tets) {
      for (const Index v : cell) number[v] = 0;
    }
    Index count = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] == kNone) continue;
      number[v] = count;
      input->vertices[count++] = input->vertices[v];
    }
    input->vertices.resize(static_cast<std::size_t>(count));
    for (auto& cell : input->tets) {
      for (Index& v : cell) v = number[v];
    }
  }

  /// The boundary is the surface that Gmsh was given, all of it filled on the right side.
  void checkBoundary(const ControlMesh& mesh) const {
    const Complex& c = *mesh.complex();
    double volume = 0;
    for (Index cell = 0; cell < c.cellCount(); ++cell) {
      volume += std::abs(cellVolume6(c, mesh.positions(), cell)) / 6;
    }
    const double expected = volumeOf(parts_);
    Index facets = 0;
    for (Index f = 0; f < c.facetCount(); ++f) facets += c.facetOnBoundary(f);
    if (facets != static_cast<Index>(boundary_.surface.triangles.size()) ||
        !(std::abs(volume - expected) <= 1e-6 * expected)) {
      throw InputError("", "Gmsh did not fill it: its tetrahedra have a volume of " +
                               std::to_string(volume) + " instead of " + std::to_string(expected));
    }
  }

  double distance() const {
    if (!report_.remeshed) return 0;
    const ClosestPoints closest(given_);
    const TriangleSurface& s = boundary_.surface;
    std::vector<double> distances(s.triangles.size());
    parallelFor<std::size_t>(
        distances.size(),
        [&](std::size_t t) {
          const auto& [a, b, c] = s.triangles[t];
          distances[t] = closest.find((s.vertices[a] + s.vertices[b] + s.vertices[c]) / 3).distance;
        },
        context_, 64);
    return *std::max_element(distances.begin(), distances.end());
  }

  TriangleSurface given_;
  const TetrahedraOptions& options_;
  const Context& context_;
  RemeshedSurface boundary_;
  std::vector<SurfacePart> parts_;  // of the boundary
  TetrahedraReport report_;
};

}  // namespace

ControlMesh fillWithTetrahedra(const TriangleSurface& surface, const TetrahedraOptions& options,
                               TetrahedraReport* report, const Context& context) {
  return TetrahedraFill(surface, options, context).run(report);
}

}  // namespace octet
