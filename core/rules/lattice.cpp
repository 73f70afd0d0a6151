// SPDX-License-Identifier: Apache-2.0
#include "lattice.h"

#include <Eigen/Dense>
#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include "smoothing_rules.h"

namespace octet {
namespace {

Int3 operator+(const Int3& a, const Int3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Int3 operator-(const Int3& a, const Int3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

/// The 48 signed permutations of the axes.
const std::array<std::array<Int3, 3>, 48>& symmetries() {
  static const auto list = [] {
    std::array<std::array<Int3, 3>, 48> result{};
    std::array<int, 3> axes = {0, 1, 2};
    int n = 0;
    do {
      for (int signs = 0; signs < 8; ++signs, ++n) {
        for (int row = 0; row < 3; ++row) {
          result[n][row] = {0, 0, 0};
          result[n][row][axes[row]] = signs >> row & 1 ? -1 : 1;
        }
      }
    } while (std::next_permutation(axes.begin(), axes.end()));
    return result;
  }();
  return list;
}

Int3 applySymmetry(int frame, const Int3& v) {
  Int3 result;
  for (int row = 0; row < 3; ++row) {
    const Int3& m = symmetries()[frame][row];
    result[row] = m[0] * v[0] + m[1] * v[1] + m[2] * v[2];
  }
  return result;
}

std::int64_t determinant(const Int3& a, const Int3& b, const Int3& c) {
  return std::int64_t{a[0]} * (b[1] * c[2] - b[2] * c[1]) -
         std::int64_t{a[1]} * (b[0] * c[2] - b[2] * c[0]) +
         std::int64_t{a[2]} * (b[0] * c[1] - b[1] * c[0]);
}

/// Sign of the permutation that sorts a triple.
int sortSign(std::array<Int3, 3>* triple) {
  auto& t = *triple;
  int sign = 1;
  for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {0, 1}}) {
    if (t[j] < t[i]) {
      std::swap(t[i], t[j]);
      sign = -sign;
    }
  }
  return sign;
}

int squaredNorm(const Int3& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

/// Looks a neighbour up by its offset; -1 when it is none.
int neighbourAt(const Lattice& lattice, const Int3& offset) {
  for (int k = 0; k <= kNeighbours; ++k) {
    if (lattice.neighbours[k] == offset) return k;
  }
  return -1;
}

using Chain = std::map<std::vector<Int3>, double>;  // simplex by its sorted vertices

/// A small explicit piece of the lattice in which chains are solved for.
class ChainSolver {
 public:
  explicit ChainSolver(const Lattice& lattice) : lattice_(lattice), patch_(2) {
    for (const auto& tet : patch_.tets) addCell<Tetrahedron>(tet);
    for (const auto& oct : patch_.octs) addCell<Octahedron>(oct);
    for (const Int3& t : lattice.edges) edgeChains_[t] = solveEdge(t);
  }

  const Chain& edgeHomotopy(const Int3& t) const { return edgeChains_.at(t); }

  /// D1 of a regular vertex (SCHEME.md section 6), as a chain of sorted edges.
  Chain vertexHomotopy(const Int3& v) const {
    Chain chain;
    std::vector<const Cell*> star;
    for (const Cell& cell : cells_) {
      if (std::count(cell.points.begin(), cell.points.end(), v)) star.push_back(&cell);
    }
    const double n = static_cast<double>(star.size());
    for (const Cell* cell : star) {
      for (const Int3& u : cell->points) {
        if (squaredNorm(u - v) != 2) continue;
        if (cell->points.size() == 4) {
          addEdge(&chain, v, u, -kTetVertexWeight / n);
        } else {
          const Int3 opposite = cell->centreTwice - v;
          addEdge(&chain, v, u, -kOctVertexWeight / n);
          addEdge(&chain, u, opposite, -kOctRingWeight / n);
        }
      }
    }
    return chain;
  }

  /// The 3-chain whose boundary is the facet minus its average minus what its edges take care of.
  Chain facetHomotopy(const std::array<Int3, 3>& facet) const {
    Chain target;
    addFacet(&target, facet, 1);
    const auto [a, b, c] = facet;  // in lexicographic order
    for (const auto& [from, to, sign] : {std::tuple{a, b, 1}, {b, c, 1}, {a, c, -1}}) {
      for (const auto& [simplex, w] : edgeHomotopy(to - from)) {
        addFacet(&target, {simplex[0] + from, simplex[1] + from, simplex[2] + from}, -sign * w);
      }
    }
    std::set<Int3> near;
    for (const Cell& cell : cells_) {
      for (const Int3& v : facet) {
        if (std::count(cell.points.begin(), cell.points.end(), v)) {
          near.insert(cell.points.begin(), cell.points.end());
        }
      }
    }
    for (int k = 0; k <= kNeighbours; ++k) {
      const Int3& offset = lattice_.neighbours[k];
      addFacet(&target, {facet[0] + offset, facet[1] + offset, facet[2] + offset},
               -translateWeight(k));
    }
    std::vector<std::vector<Int3>> cells;
    std::vector<Chain> boundaries;
    for (const Cell& cell : cells_) {
      if (!subset(cell.points, near)) continue;
      Chain boundary;
      for (const auto& outward : cell.outward) addFacet(&boundary, outward, 1);
      cells.push_back(sorted(cell.points));
      boundaries.push_back(std::move(boundary));
    }
    return leastNorm(cells, boundaries, target);
  }

  /// Does some cell have all of `simplex` and one of `vertices`? Then it exists around R vertices.
  bool inStar(const std::vector<Int3>& simplex, const std::vector<Int3>& vertices) const {
    return std::any_of(cells_.begin(), cells_.end(), [&](const Cell& cell) {
      const std::set<Int3> points(cell.points.begin(), cell.points.end());
      return subset(simplex, points) &&
             std::any_of(vertices.begin(), vertices.end(),
                         [&](const Int3& v) { return points.count(v) > 0; });
    });
  }

 private:
  struct Cell {
    std::vector<Int3> points;
    std::vector<std::array<Int3, 3>> outward;  // facets, outward in the lattice
    Int3 centreTwice{};                        // of an octahedron
  };

  /// The 2-chain of least norm whose boundary is edge (0,t) minus its average minus what D1 takes
  /// care of; on facets with all vertices among the neighbours of either end.
  Chain solveEdge(const Int3& t) const {
    const Int3 origin = {0, 0, 0};
    Chain target;
    addEdge(&target, origin, t, 1);
    for (const auto& [edge, w] : vertexHomotopy(t)) target[edge] -= w;
    for (const auto& [edge, w] : vertexHomotopy(origin)) target[edge] += w;
    std::set<Int3> near;
    for (int k = 0; k <= kNeighbours; ++k) {
      const Int3& offset = lattice_.neighbours[k];
      addEdge(&target, offset, t + offset, -translateWeight(k));
      near.insert({offset, t + offset});
    }
    std::vector<std::vector<Int3>> facets;
    std::vector<Chain> boundaries;
    for (const auto& facet : facets_) {
      if (!subset(facet, near)) continue;
      Chain boundary;
      for (int k = 0; k < 3; ++k) addEdge(&boundary, facet[k], facet[(k + 1) % 3], 1);
      facets.push_back(facet);
      boundaries.push_back(std::move(boundary));
    }
    return leastNorm(facets, boundaries, target);
  }

  template <typename Shape, typename Vertices>
  void addCell(const Vertices& vertices) {
    Cell cell;
    for (const auto v : vertices) cell.points.push_back(patch_.points[v]);
    if constexpr (Shape::kVertices == 6) cell.centreTwice = cell.points[0] + cell.points[5];
    for (const auto& f : Shape::facets) {
      std::array<Int3, 3> t = {cell.points[f[0]], cell.points[f[1]], cell.points[f[2]]};
      // Outward: away from any vertex that is not on the facet.
      const Int3* off = nullptr;
      for (const Int3& p : cell.points) {
        if (p != t[0] && p != t[1] && p != t[2]) off = &p;
      }
      if (determinant(t[1] - t[0], t[2] - t[0], *off - t[0]) > 0) std::swap(t[1], t[2]);
      cell.outward.push_back(t);
      sortSign(&t);
      facets_.insert({t[0], t[1], t[2]});
    }
    cells_.push_back(std::move(cell));
  }

  static std::vector<Int3> sorted(std::vector<Int3> points) {
    std::sort(points.begin(), points.end());
    return points;
  }
  template <typename Points>
  static bool subset(const Points& simplex, const std::set<Int3>& of) {
    return std::all_of(simplex.begin(), simplex.end(),
                       [&](const Int3& p) { return of.count(p) > 0; });
  }
  static void addEdge(Chain* chain, const Int3& a, const Int3& b, double w) {
    (*chain)[a < b ? std::vector{a, b} : std::vector{b, a}] += a < b ? w : -w;
  }
  static void addFacet(Chain* chain, std::array<Int3, 3> t, double w) {
    const int sign = sortSign(&t);
    (*chain)[{t[0], t[1], t[2]}] += sign * w;
  }

  /// Least-norm x with sum x_i boundary_i = target.
  static Chain leastNorm(const std::vector<std::vector<Int3>>& simplices,
                         const std::vector<Chain>& boundaries, const Chain& target) {
    std::map<std::vector<Int3>, int> rows;
    for (const auto& [simplex, w] : target) rows.emplace(simplex, 0);
    for (const Chain& boundary : boundaries) {
      for (const auto& [simplex, w] : boundary) rows.emplace(simplex, 0);
    }
    int n = 0;
    for (auto& [simplex, row] : rows) row = n++;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, static_cast<int>(simplices.size()));
    Eigen::VectorXd y = Eigen::VectorXd::Zero(n);
    for (const auto& [simplex, w] : target) y[rows[simplex]] = w;
    for (std::size_t j = 0; j < boundaries.size(); ++j) {
      for (const auto& [simplex, w] : boundaries[j]) a(rows[simplex], static_cast<int>(j)) = w;
    }
    const Eigen::VectorXd x = a.completeOrthogonalDecomposition().solve(y);
    if ((a * x - y).cwiseAbs().maxCoeff() > 1e-12) throw std::logic_error("lattice chain open");
    Chain chain;
    for (std::size_t j = 0; j < simplices.size(); ++j) {
      if (std::abs(x[static_cast<int>(j)]) > 1e-12) chain[simplices[j]] = x[static_cast<int>(j)];
    }
    return chain;
  }

  const Lattice& lattice_;
  LatticePatch patch_;
  std::vector<Cell> cells_;
  std::set<std::vector<Int3>> facets_;
  std::map<Int3, Chain> edgeChains_;
};

template <typename Shape>
CellPlacement<Shape> placement(const Lattice& lattice, int frame) {
  CellPlacement<Shape> result{};
  std::array<Int3, Shape::kVertices> p;
  for (int i = 0; i < Shape::kVertices; ++i) {
    p[i] = applySymmetry(frame, canonicalPoints<Shape>()[i]);
  }
  for (int i = 0; i < Shape::kVertices; ++i) {
    for (int j = 0; j < Shape::kVertices; ++j) {
      result.neighbour[i][j] = static_cast<std::uint8_t>(neighbourAt(lattice, p[j] - p[i]));
    }
  }
  for (int k = 0; k < Shape::kEdges; ++k) {
    const auto [i, j] = std::pair{Shape::edges[k][0], Shape::edges[k][1]};
    const bool forward = p[i] < p[j];
    const Int3 step = forward ? p[j] - p[i] : p[i] - p[j];
    const auto found = std::find(lattice.edges.begin(), lattice.edges.end(), step);
    result.edges[k] = {forward ? i : j, static_cast<std::uint8_t>(found - lattice.edges.begin()),
                       static_cast<std::int8_t>(forward ? 1 : -1)};
  }
  const auto localVertex = [&](const Int3& point) {
    return static_cast<std::uint8_t>(std::find(p.begin(), p.end(), point) - p.begin());
  };
  for (int k = 0; k < Shape::kFacets; ++k) {
    const auto& f = Shape::facets[k];
    std::array<Int3, 3> t = {p[f[0]], p[f[1]], p[f[2]]};
    const int sign = sortSign(&t);
    const std::array<Int3, 2> steps = {t[1] - t[0], t[2] - t[0]};
    const auto found = std::find(lattice.facets.begin(), lattice.facets.end(), steps);
    result.facets[k] = {localVertex(t[0]),
                        static_cast<std::uint8_t>(found - lattice.facets.begin()),
                        static_cast<std::int8_t>(sign)};
  }
  const Int3 base = *std::min_element(p.begin(), p.end());
  const Int3 next = *std::min_element(p.begin(), p.end(), [&](const Int3& a, const Int3& b) {
    return (a == base ? Int3{9, 9, 9} : a) < (b == base ? Int3{9, 9, 9} : b);
  });
  // The two tetrahedron classes differ in the direction from the base to the next vertex.
  const std::uint8_t cellClass = Shape::kVertices == 6 ? 2 : next[2] > base[2] ? 1 : 0;
  const auto& f = Shape::facets[0];
  const std::uint8_t off = Shape::kVertices == 6 ? 5 : 0;  // a vertex not on facet 0
  const bool outward = determinant(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]], p[off] - p[f[0]]) < 0;
  result.cell = {localVertex(base), cellClass, static_cast<std::int8_t>(outward ? 1 : -1)};
  return result;
}

template <typename Shape>
int frameOf(const std::array<Int3, Shape::kVertices>& points) {
  for (int frame = 0; frame < 48; ++frame) {
    const auto& own = canonicalPoints<Shape>();
    bool fits = true;
    for (int i = 1; i < Shape::kVertices && fits; ++i) {
      fits = applySymmetry(frame, own[i] - own[0]) == points[i] - points[0];
    }
    if (fits) return frame;
  }
  throw std::logic_error("not a lattice cell");
}

}  // namespace

template <>
const std::array<Int3, 4>& canonicalPoints<Tetrahedron>() {
  static const std::array<Int3, 4> points = {{{0, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}}};
  return points;
}

template <>
const std::array<Int3, 6>& canonicalPoints<Octahedron>() {
  static const std::array<Int3, 6> points = {
      {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}}};
  return points;
}

LatticePatch::LatticePatch(int radius) {
  const int reach = radius + 2;
  std::map<Int3, std::int32_t> ids;
  const auto id = [&](const Int3& p) {
    const auto [it, added] = ids.emplace(p, static_cast<std::int32_t>(points.size()));
    if (added) points.push_back(p);
    return it->second;
  };
  const auto inBox = [&](const Int3& p) {
    return std::abs(p[0]) <= radius && std::abs(p[1]) <= radius && std::abs(p[2]) <= radius;
  };
  for (int x = -reach; x <= reach; ++x) {
    for (int y = -reach; y <= reach; ++y) {
      for (int z = -reach; z <= reach; ++z) {
        const Int3 p = {x, y, z};
        const bool odd = (x + y + z) % 2 != 0;
        if (odd) {
          std::array<Int3, 6> corners;
          for (int i = 0; i < 6; ++i) corners[i] = p + canonicalPoints<Octahedron>()[i];
          if (std::any_of(corners.begin(), corners.end(), inBox)) {
            octs.push_back({});
            for (int i = 0; i < 6; ++i) octs.back()[i] = id(corners[i]);
          }
        }
        // The even corners of the unit cube at p.
        std::array<Int3, 4> corners;
        for (int i = 0; i < 4; ++i) {
          const Int3& c = canonicalPoints<Tetrahedron>()[i];
          corners[i] = p + (odd ? Int3{1 - c[0], 1 - c[1], 1 - c[2]} : c);
        }
        if (std::any_of(corners.begin(), corners.end(), inBox)) {
          tets.push_back({});
          for (int i = 0; i < 4; ++i) tets.back()[i] = id(corners[i]);
        }
      }
    }
  }
}

Int3 Lattice::rotate(int frame, const Int3& v) const { return applySymmetry(frame, v); }

template <typename Shape>
bool Lattice::place(const std::array<int, 3>& local, const std::array<Int3, 3>& at, int* frame,
                    std::array<Int3, Shape::kVertices>* points) const {
  const auto& own = canonicalPoints<Shape>();
  for (int g = 0; g < 48; ++g) {
    const Int3 shift = at[0] - applySymmetry(g, own[local[0]]);
    if (applySymmetry(g, own[local[1]]) + shift != at[1]) continue;
    if (applySymmetry(g, own[local[2]]) + shift != at[2]) continue;
    *frame = g;
    for (int i = 0; i < Shape::kVertices; ++i) (*points)[i] = applySymmetry(g, own[i]) + shift;
    return true;
  }
  return false;
}

template bool Lattice::place<Tetrahedron>(const std::array<int, 3>&, const std::array<Int3, 3>&,
                                          int*, std::array<Int3, 4>*) const;
template bool Lattice::place<Octahedron>(const std::array<int, 3>&, const std::array<Int3, 3>&,
                                         int*, std::array<Int3, 6>*) const;

Lattice::Lattice() {
  // Neighbours: 12 at squared distance 2, 6 at 4, then the point itself.
  int n = 0;
  for (const int wanted : {2, 4, 0}) {
    for (int x = -2; x <= 2; ++x) {
      for (int y = -2; y <= 2; ++y) {
        for (int z = -2; z <= 2; ++z) {
          const Int3 p = {x, y, z};
          if ((x + y + z) % 2 == 0 && squaredNorm(p) == wanted) neighbours[n++] = p;
        }
      }
    }
  }
  // Classes: steps that are lexicographically positive; facets with two such steps one edge apart.
  n = 0;
  for (int k = 0; k < 12; ++k) {
    if (Int3{0, 0, 0} < neighbours[k]) edges[n++] = neighbours[k];
  }
  n = 0;
  for (const Int3& a : edges) {
    for (const Int3& b : edges) {
      if (a < b && squaredNorm(b - a) == 2) facets[n++] = {a, b};
    }
  }
  for (int outer = 0; outer < 48; ++outer) {
    for (int inner = 0; inner < 48; ++inner) {
      for (int g = 0; g < 48; ++g) {
        bool same = true;
        for (int axis = 0; axis < 3; ++axis) {
          Int3 unit = {0, 0, 0};
          unit[axis] = 1;
          same &= applySymmetry(g, unit) == applySymmetry(outer, applySymmetry(inner, unit));
        }
        if (same) products[outer][inner] = static_cast<std::uint8_t>(g);
      }
    }
  }
  for (int g = 0; g < 48; ++g) {
    tetPlacements[g] = placement<Tetrahedron>(*this, g);
    octPlacements[g] = placement<Octahedron>(*this, g);
  }

  // Children (SCHEME.md section 3), in coordinates of the fine lattice.
  {
    const auto& t = canonicalPoints<Tetrahedron>();
    const auto& o = canonicalPoints<Octahedron>();
    tetToOct = frameOf<Octahedron>(
        {t[0] + t[1], t[0] + t[2], t[0] + t[3], t[1] + t[3], t[1] + t[2], t[2] + t[3]});
    for (int f = 0; f < 8; ++f) {
      const auto& [i, j, l] = Octahedron::facets[f];
      octToTet[f] = static_cast<std::uint8_t>(
          frameOf<Tetrahedron>({o[i] + o[j], o[j] + o[l], o[i] + o[l], o[0] + o[5]}));
    }
  }

  // Ends and boundaries of the classes, read off the cells that have them.
  for (int c = 0; c < kEdgeClasses; ++c) {
    edgeEnd[c] = static_cast<std::uint8_t>(neighbourAt(*this, edges[c]));
  }
  for (int c = 0; c < kFacetClasses; ++c) {
    const auto& [a, b] = facets[c];
    facetEnds[c] = {static_cast<std::uint8_t>(neighbourAt(*this, a)),
                    static_cast<std::uint8_t>(neighbourAt(*this, b))};
    const auto edgeClass = [&](const Int3& step) {
      return static_cast<std::uint8_t>(std::find(edges.begin(), edges.end(), step) - edges.begin());
    };
    facetBoundary[c] = {LatticeTerm{{kSelf, kSelf}, edgeClass(a), true, 1},
                        LatticeTerm{{facetEnds[c][0], kSelf}, edgeClass(b - a), true, 1},
                        LatticeTerm{{kSelf, kSelf}, edgeClass(b), true, -1}};
  }
  const auto readCell = [&](const auto& place, auto shape) {
    using Shape = decltype(shape);
    const int c = place.cell.simplexClass, base = place.cell.base;
    if (!cellBoundary[c].empty()) return;
    cellEndCount[c] = 0;
    for (int i = 0; i < Shape::kVertices; ++i) {
      if (i != base) cellEnds[c][cellEndCount[c]++] = place.neighbour[base][i];
    }
    for (int f = 0; f < Shape::kFacets; ++f) {
      const LatticeSlot& slot = place.facets[f];
      const std::uint8_t hop = slot.base == base ? kSelf : place.neighbour[base][slot.base];
      cellBoundary[c].push_back({{hop, kSelf},
                                 slot.simplexClass,
                                 true,
                                 static_cast<double>(slot.sign * place.cell.sign)});
    }
  };
  for (int g = 0; g < 48; ++g) {
    readCell(tetPlacements[g], Tetrahedron{});
    readCell(octPlacements[g], Octahedron{});
  }

  // Homotopy rows: the simplices of each chain, reached through a vertex of the target.
  const ChainSolver solver(*this);
  const auto term = [&](const std::vector<Int3>& simplex, const std::vector<Int3>& targetVertices,
                        std::uint8_t simplexClass, double weight) {
    for (const Int3& via : targetVertices) {
      const int hop = neighbourAt(*this, simplex[0] - via);
      if (hop < 0) continue;
      return LatticeTerm{
          {static_cast<std::uint8_t>(neighbourAt(*this, via)), static_cast<std::uint8_t>(hop)},
          simplexClass,
          solver.inStar(simplex, targetVertices),
          weight};
    }
    throw std::logic_error("lattice chain out of reach");
  };
  for (int c = 0; c < kEdgeClasses; ++c) {
    for (const auto& [simplex, w] : solver.edgeHomotopy(edges[c])) {
      const std::array<Int3, 2> steps = {simplex[1] - simplex[0], simplex[2] - simplex[0]};
      const auto found = std::find(facets.begin(), facets.end(), steps) - facets.begin();
      edgeHomotopy[c].push_back(
          term(simplex, {{0, 0, 0}, edges[c]}, static_cast<std::uint8_t>(found), w));
    }
  }
  for (int c = 0; c < kFacetClasses; ++c) {
    const Int3 origin = {0, 0, 0};
    for (const auto& [simplex, w] : solver.facetHomotopy({origin, facets[c][0], facets[c][1]})) {
      const Int3 step = simplex[1] - simplex[0];
      const int cellClass = simplex.size() == 6 ? 2 : step[2] > 0 ? 1 : 0;
      facetHomotopy[c].push_back(term(simplex, {origin, facets[c][0], facets[c][1]},
                                      static_cast<std::uint8_t>(cellClass), w));
    }
  }
}

const Lattice& Lattice::get() {
  static const Lattice lattice;
  return lattice;
}

}  // namespace octet
