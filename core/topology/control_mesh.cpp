// SPDX-License-Identifier: Apache-2.0
#include "control_mesh.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <tbb/parallel_sort.h>

#include "../base/error.h"
#include "../base/numbers.h"
#include "../base/parallel.h"
#include "../base/sort_unique.h"
#include "lattice_regions.h"
#include "overlap.h"

namespace octet {
namespace {

/// Cells of less volume than this times the cube of their longest edge are degenerate, and those
/// with a facet of less area than this times its square.
constexpr double kFlatCell = 1e-12;
/// Largest coordinate: products of four still are finite, and grids hold 32-bit floats.
constexpr double kLargestCoordinate = 1e30;
/// Least length of a cell's longest edge, likewise.
constexpr double kSmallestCell = 1e-30;
/// Boundary edges whose facets' normals differ by more are creases by default.
constexpr double kCreaseAngle = 40.0;

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

std::string tuple(const Index* v, int n) {
  std::string text = "(";
  for (int k = 0; k < n; ++k) text += (k ? "," : "") + std::to_string(v[k]);
  return text + ")";
}

/// A facet of a cell, by its sorted vertices.
struct FacetUse {
  std::array<Index, 3> vertices;
  Index cell;
  std::int8_t facet;
  std::uint8_t permutation;  ///< from the outward triple to the sorted one

  bool operator<(const FacetUse& o) const {
    return std::tie(vertices, cell, facet) < std::tie(o.vertices, o.cell, o.facet);
  }
};

class Builder {
 public:
  Builder(ControlMeshInput input, Complex* complex, std::vector<Index>* corners,
          const Context& context)
      : in_(std::move(input)), c_(*complex), corners_(*corners), context_(context) {}

  Array<Vec3> run() {
    checkVertices();
    checkCells("tetrahedra", in_.tets);
    checkCells("octahedra", in_.octs);
    if (in_.tets.empty() && in_.octs.empty()) {
      throw InputError("", "the mesh has no tetrahedra and no octahedra");
    }
    c_.vertexTypes.assign(in_.vertices.size(), VertexType::X3);
    c_.tets = std::move(in_.tets);
    c_.octs = std::move(in_.octs);
    for (const auto part :
         {&Builder::numberFacets, &Builder::numberEdges, &Builder::orientCells, &Builder::joinCells,
          &Builder::buildStars, &Builder::markBoundary, &Builder::markCreases}) {
      context_.poll();
      (this->*part)();
    }
    context_.poll();
    if (in_.cellRegions.empty()) {
      findLatticeRegions(&c_);
    } else {
      c_.cellRegions = std::move(in_.cellRegions);
      c_.cellFrames = std::move(in_.cellFrames);
    }
    classifyVertices();
    if (!in_.cellSigns.empty()) return std::move(in_.vertices);
    if (const auto overlap = findOverlap(c_, in_.vertices, context_)) {
      throw InputError(ControlMesh::cellName(c_, overlap->cell),
                       "overlaps " + ControlMesh::cellName(c_, overlap->other));
    }
    return std::move(in_.vertices);
  }

 private:
  void checkVertices() const {
    for (std::size_t i = 0; i < in_.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const double x = in_.vertices[i][k];
        const std::string place = "vertices[" + std::to_string(i) + "]";
        if (!std::isfinite(x)) throw InputError(place, "coordinate is not a finite number");
        if (std::abs(x) > kLargestCoordinate) {
          throw InputError(place, "coordinate " + number(x) + " is larger than 1e30");
        }
      }
    }
  }

  template <typename Cells>
  void checkCells(const char* name, const Cells& cells) const {
    const Index n = static_cast<Index>(in_.vertices.size());
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const std::string place = std::string(name) + "[" + std::to_string(k) + "]";
      for (std::size_t i = 0; i < cells[k].size(); ++i) {
        const Index v = cells[k][i];
        if (v < 0 || v >= n) {
          throw InputError(place, "vertex " + std::to_string(v) + " is out of range, there are " +
                                      std::to_string(n) + " vertices");
        }
        if (std::count(cells[k].begin(), cells[k].end(), v) > 1) {
          throw InputError(place, "vertex " + std::to_string(v) + " is repeated");
        }
      }
    }
  }

  template <typename Shape, typename Vertices>
  static void collect(const Vertices& v, Index cell, FacetUse* out) {
    for (int k = 0; k < Shape::kFacets; ++k) {
      FacetUse& use = out[k];
      for (int j = 0; j < 3; ++j) use.vertices[j] = v[Shape::facets[k][j]];
      const auto unsorted = use.vertices;
      std::sort(use.vertices.begin(), use.vertices.end());
      const auto placeOf = [&](Index x) {
        return static_cast<int>(std::find(use.vertices.begin(), use.vertices.end(), x) -
                                use.vertices.begin());
      };
      use.cell = cell;
      use.facet = static_cast<std::int8_t>(k);
      use.permutation = permutationOf(placeOf(unsorted[0]), placeOf(unsorted[1]));
    }
  }

  void numberFacets() {
    const Index t = c_.tetCount(), o = c_.octCount();
    if (std::int64_t{4} * t + std::int64_t{8} * o >= FacetRef::kMaxFacets) {
      throw InputError("", "the mesh has more cells than can be numbered");
    }
    Array<FacetUse> uses(4 * static_cast<std::size_t>(t) + 8 * static_cast<std::size_t>(o));
    parallelFor<Index>(t, [&](Index k) { collect<Tetrahedron>(c_.tets[k], k, &uses[4 * k]); });
    parallelFor<Index>(
        o, [&](Index k) { collect<Octahedron>(c_.octs[k], t + k, &uses[4 * t + 8 * k]); });
    context_.poll();
    tbb::parallel_sort(uses.begin(), uses.end());
    context_.poll();
    c_.tetFacets.resize(t);
    c_.octFacets.resize(o);
    for (std::size_t k = 0; k < uses.size(); ++k) {
      const FacetUse& use = uses[k];
      if (k == 0 || use.vertices != uses[k - 1].vertices) facetVertices_.push_back(use.vertices);
      if (k >= 2 && use.vertices == uses[k - 2].vertices) {
        throw InputError(name(use.cell), "facet " + tuple(use.vertices.data(), 3) +
                                             " is shared by three cells, also " +
                                             name(uses[k - 2].cell) + " and " +
                                             name(uses[k - 1].cell));
      }
      const FacetRef ref(static_cast<Index>(facetVertices_.size()) - 1, use.permutation);
      if (use.cell < t) {
        c_.tetFacets[use.cell][use.facet] = ref;
      } else {
        c_.octFacets[use.cell - t][use.facet] = ref;
      }
    }
  }

  void numberEdges() {
    c_.edges.reserve(3 * facetVertices_.size());
    for (const auto& [a, b, c] : facetVertices_) {
      for (const auto& edge : {std::array{a, b}, {b, c}, {a, c}}) c_.edges.push_back(edge);
    }
    context_.poll();
    tbb::parallel_sort(c_.edges.begin(), c_.edges.end());
    context_.poll();
    c_.edges.erase(std::unique(c_.edges.begin(), c_.edges.end()), c_.edges.end());
    c_.edges.shrink_to_fit();
    c_.edgeFlags.assign(c_.edges.size(), kOnControlEdge);
    c_.facetEdges.resize(facetVertices_.size());
    parallelFor<Index>(c_.facetCount(), [&](Index f) {
      const auto& [a, b, c] = facetVertices_[f];
      c_.facetEdges[f] = {EdgeRef(edgeIndex(a, b), false), EdgeRef(edgeIndex(b, c), false),
                          EdgeRef(edgeIndex(a, c), true)};
    });
  }

  Index edgeIndex(Index a, Index b) const {
    const std::array<Index, 2> key = {a, b};
    return static_cast<Index>(std::lower_bound(c_.edges.begin(), c_.edges.end(), key) -
                              c_.edges.begin());
  }

  void orientCells() {
    if (!in_.cellSigns.empty()) {
      c_.cellSigns = in_.cellSigns;
      return;
    }
    c_.cellSigns.resize(c_.cellCount());
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      double longest = 0;
      for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
        for (int j = 0; j < i; ++j)
          longest = std::max(longest, (point(cell, i) - point(cell, j)).norm());
      }
      if (longest < kSmallestCell) {
        throw InputError(name(cell), "is degenerate: its longest edge is " + number(longest));
      }
      const double volume = cellVolume6(c_, in_.vertices, cell);
      if (!(std::abs(volume) > kFlatCell * longest * longest * longest)) {
        throw InputError(name(cell), "is degenerate: its volume is " + number(volume / 6) +
                                         ", its longest edge " + number(longest));
      }
      checkFacetAreas(cell, longest);
      c_.cellSigns[cell] = volume > 0 ? 1 : -1;
    }
  }

  /// An octahedron can have volume although two neighbouring vertices coincide.
  void checkFacetAreas(Index cell, double longest) const {
    for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
      const auto& [a, b, c] = facetVertices_[c_.cellFacet(cell, k).index()];
      const Vec3 normal =
          (in_.vertices[b] - in_.vertices[a]).cross(in_.vertices[c] - in_.vertices[a]);
      if (!(normal.norm() > kFlatCell * longest * longest)) {
        throw InputError(name(cell),
                         "is degenerate: its facet " +
                             tuple(facetVertices_[c_.cellFacet(cell, k).index()].data(), 3) +
                             " has no area");
      }
    }
  }

  const Vec3& point(Index cell, int i) const { return in_.vertices[c_.cellVertex(cell, i)]; }

  void joinCells() {
    c_.facetCells.resize(c_.facetCount());
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
        const FacetRef facet = c_.cellFacet(cell, k);
        const bool outward = (c_.cellSigns[cell] > 0) == (facet.sign() > 0);
        CellSide& side = c_.facetCells[facet.index()][outward ? 0 : 1];
        if (side.exists()) {
          throw InputError(name(cell), "overlaps " + name(side.cell()) +
                                           ": both lie on the same side of facet " +
                                           tuple(facetVertices_[facet.index()].data(), 3));
        }
        side = CellSide(cell, k);
      }
    }
  }

  void buildStars() {
    const auto countInto = [](Array<Index>* begin, Index row) { ++(*begin)[row + 1]; };
    const auto accumulate = [](Array<Index>* begin) {
      for (std::size_t k = 1; k < begin->size(); ++k) (*begin)[k] += (*begin)[k - 1];
      return Array<Index>(begin->begin(), begin->end() - 1);
    };
    c_.vertexStarBegin.assign(c_.vertexCount() + 1, 0);
    c_.edgeStarBegin.assign(c_.edgeCount() + 1, 0);
    const auto visitEdges = [&](Index cell, const auto& visit) {
      for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
        for (int j = i + 1; j < c_.cellVertexCount(cell); ++j) {
          if (!c_.isTet(cell) && Octahedron::opposite[i] == j) continue;
          visit(c_.cellEdge(cell, i, j), i, j);
        }
      }
    };
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
        countInto(&c_.vertexStarBegin, c_.cellVertex(cell, i));
      }
      visitEdges(cell, [&](EdgeRef e, int, int) { countInto(&c_.edgeStarBegin, e.index()); });
    }
    auto nextAtVertex = accumulate(&c_.vertexStarBegin);
    auto nextAtEdge = accumulate(&c_.edgeStarBegin);
    c_.vertexStars.resize(c_.vertexStarBegin.back());
    c_.edgeStars.resize(c_.edgeStarBegin.back());
    for (Index cell = 0; cell < c_.cellCount(); ++cell) {
      for (int i = 0; i < c_.cellVertexCount(cell); ++i) {
        c_.vertexStars[nextAtVertex[c_.cellVertex(cell, i)]++] = {cell, i};
      }
      visitEdges(cell, [&](EdgeRef e, int i, int j) {
        if (e.reversed()) std::swap(i, j);
        c_.edgeStars[nextAtEdge[e.index()]++] = {cell, i, j};
      });
    }
  }

  void markBoundary() {
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      for (const EdgeRef& e : c_.facetEdges[f]) c_.edgeFlags[e.index()] |= kOnBoundary;
      for (const Index v : facetVertices_[f]) c_.vertexTypes[v] = VertexType::B3;
    }
  }

  void markCreases() {
    if (in_.creases) {
      markGivenCreases();
    } else {
      guessCreases();
    }
    checkCorners();
  }

  /// Sharp boundary edges, and those where more than two boundary facets meet.
  void guessCreases() {
    // Boundary edges with their outward normals; a surface has two facets at each.
    struct AtEdge {
      int facets = 0;
      Vec3 normals[2];
    };
    Array<AtEdge> at(c_.edgeCount());
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      const auto& [a, b, c] = facetVertices_[f];
      Vec3 normal = (in_.vertices[b] - in_.vertices[a]).cross(in_.vertices[c] - in_.vertices[a]);
      if (!c_.facetCells[f][0].exists()) normal = -normal;
      for (const EdgeRef& e : c_.facetEdges[f]) {
        AtEdge& edge = at[e.index()];
        if (edge.facets < 2) edge.normals[edge.facets] = normal.normalized();
        ++edge.facets;
      }
    }
    const double flat = std::cos(kCreaseAngle * kPi / 180);
    for (Index e = 0; e < c_.edgeCount(); ++e) {
      const AtEdge& edge = at[e];
      if (edge.facets == 0) continue;
      const bool sharp = edge.facets != 2 || edge.normals[0].dot(edge.normals[1]) < flat;
      if (sharp) c_.edgeFlags[e] |= kOnCrease;
    }
  }

  void markGivenCreases() {
    for (std::size_t k = 0; k < in_.creases->size(); ++k) {
      auto [a, b] = (*in_.creases)[k];
      const std::string place = "creases[" + std::to_string(k) + "]";
      if (a > b) std::swap(a, b);
      const Index e = edgeIndex(a, b);
      const std::array<Index, 2> edge = {a, b};
      if (e == c_.edgeCount() || c_.edges[e] != edge) {
        throw InputError(place, "the mesh has no edge " + tuple(edge.data(), 2));
      }
      if (!c_.edgeOnBoundary(e)) {
        throw InputError(place, "edge " + tuple(edge.data(), 2) +
                                    " is inside the mesh; creases belong to its boundary");
      }
      c_.edgeFlags[e] |= kOnCrease;
    }
  }

  void checkCorners() {
    for (std::size_t k = 0; k < in_.corners.size(); ++k) {
      const Index v = in_.corners[k];
      const std::string place = "corners[" + std::to_string(k) + "]";
      if (v < 0 || v >= c_.vertexCount()) {
        throw InputError(place, "vertex " + std::to_string(v) + " is out of range, there are " +
                                    std::to_string(c_.vertexCount()) + " vertices");
      }
      if (!c_.vertexOnBoundary(v)) {
        const bool used = c_.vertexStarBegin[v] < c_.vertexStarBegin[v + 1];
        throw InputError(place, "vertex " + std::to_string(v) +
                                    (used ? " is inside the mesh; corners belong to its boundary"
                                          : " belongs to no cell"));
      }
    }
    corners_ = std::move(in_.corners);
    sortUnique(&corners_);
  }

  void classifyVertices() {
    parallelFor<Index>(c_.vertexCount(), [&](Index v) {
      const Index begin = c_.vertexStarBegin[v], end = c_.vertexStarBegin[v + 1];
      if (c_.vertexOnBoundary(v) || end - begin != 14) return;
      const Index region = c_.cellRegions[c_.vertexStars[begin].cell];
      for (Index k = begin; k < end; ++k) {
        if (c_.cellRegions[c_.vertexStars[k].cell] != region) return;
      }
      c_.vertexTypes[v] = VertexType::R;
    });
  }

  std::string name(Index cell) const { return ControlMesh::cellName(c_, cell); }

  ControlMeshInput in_;
  Complex& c_;
  std::vector<Index>& corners_;
  const Context& context_;
  Array<std::array<Index, 3>> facetVertices_;
};

}  // namespace

double cellVolume6(const Complex& complex, const Array<Vec3>& positions, Index cell) {
  const int n = complex.cellVertexCount(cell);
  Vec3 p[6], centroid = Vec3::Zero();
  for (int i = 0; i < n; ++i) {
    p[i] = positions[complex.cellVertex(cell, i)];
    centroid += p[i] / n;
  }
  const auto* facets = complex.isTet(cell) ? Tetrahedron::facets : Octahedron::facets;
  double volume = 0;
  for (int k = 0; k < complex.cellFacetCount(cell); ++k) {
    const auto& f = facets[k];
    volume += (p[f[0]] - centroid).dot((p[f[1]] - centroid).cross(p[f[2]] - centroid));
  }
  return volume;
}

ControlMesh ControlMesh::build(ControlMeshInput input, const Context& context) {
  ControlMesh mesh;
  auto complex = std::make_shared<Complex>();
  mesh.positions_ = Builder(std::move(input), complex.get(), &mesh.corners_, context).run();
  mesh.complex_ = std::move(complex);
  return mesh;
}

std::string ControlMesh::cellName(const Complex& complex, Index cell) {
  return complex.isTet(cell) ? "tetrahedra[" + std::to_string(cell) + "]"
                             : "octahedra[" + std::to_string(cell - complex.tetCount()) + "]";
}

EdgeRef ControlMesh::edge(Index a, Index b) const {
  const std::array<Index, 2> key = {std::min(a, b), std::max(a, b)};
  const auto& edges = complex_->edges;
  const auto found = std::lower_bound(edges.begin(), edges.end(), key);
  if (found == edges.end() || *found != key) {
    const Index given[2] = {a, b};
    throw InputError("", "the mesh has no edge " + tuple(given, 2));
  }
  return EdgeRef(static_cast<Index>(found - edges.begin()), a > b);
}

FacetRef ControlMesh::facet(Index a, Index b, Index c) const {
  std::array<Index, 3> key = {a, b, c};
  std::sort(key.begin(), key.end());
  const auto fail = [&] {
    const Index given[3] = {a, b, c};
    return InputError("", "the mesh has no facet " + tuple(given, 3));
  };
  // Facets are in lexicographic order, so a binary search over their numbers finds it.
  Index low = 0, high = complex_->facetCount();
  while (low < high) {
    const Index mid = low + (high - low) / 2;
    if (complex_->facetVertices(mid) < key) {
      low = mid + 1;
    } else {
      high = mid;
    }
  }
  if (low == complex_->facetCount() || complex_->facetVertices(low) != key) throw fail();
  const auto place = [&](Index v) {
    return static_cast<int>(std::find(key.begin(), key.end(), v) - key.begin());
  };
  return FacetRef(low, permutationOf(place(a), place(b)));
}

}  // namespace octet
