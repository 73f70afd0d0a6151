// SPDX-License-Identifier: Apache-2.0
#include "virtual_layer.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <numeric>
#include <set>

#include "../base/error.h"
#include "../base/parallel.h"

namespace octet {
namespace {

Int3 operator+(const Int3& a, const Int3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Int3 operator-(const Int3& a, const Int3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
bool odd(const Int3& p) { return (p[0] + p[1] + p[2]) & 1; }

/// The tetrahedron in the unit cube at a point: its corners of even sum.
std::array<Int3, 4> tetAt(const Int3& p) {
  std::array<Int3, 4> corners = canonicalPoints<Tetrahedron>();
  for (Int3& c : corners) c = p + (odd(p) ? Int3{1 - c[0], 1 - c[1], 1 - c[2]} : c);
  return corners;
}

/// The octahedron around an odd point.
std::array<Int3, 6> octAt(const Int3& p) {
  std::array<Int3, 6> corners = canonicalPoints<Octahedron>();
  for (Int3& c : corners) c = p + c;
  return corners;
}

// ---- a mesh that is one lattice region ---------------------------------------------------------

class LatticeLayer {
 public:
  LatticeLayer(const ControlMesh& mesh, VirtualLayer* out) : c_(*mesh.complex()), out_(*out) {}

  /// false when the mesh is not one region in which all cells hang together.
  bool run() {
    const auto& regions = c_.cellRegions;
    if (std::any_of(regions.begin(), regions.end(), [&](Index r) { return r != regions[0]; })) {
      return false;
    }
    if (!findSites()) return false;
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      if (c_.vertexOnBoundary(v)) completeStar(out_.sites[static_cast<std::size_t>(v)]);
    }
    placeVertices();
    return true;
  }

 private:
  bool findSites() {
    const Lattice& lattice = Lattice::get();
    std::vector<std::uint8_t> known(static_cast<std::size_t>(c_.vertexCount()), 0);
    out_.sites.assign(known.size(), Int3{});
    std::vector<Index> queue = {0};
    std::vector<std::uint8_t> seen(static_cast<std::size_t>(c_.cellCount()), 0);
    seen[0] = 1;
    known[static_cast<std::size_t>(c_.cellVertex(0, 0))] = 1;
    for (std::size_t k = 0; k < queue.size(); ++k) {
      const Index cell = queue[k];
      const int n = c_.cellVertexCount(cell);
      int base = 0;
      while (!known[static_cast<std::size_t>(c_.cellVertex(cell, base))]) ++base;
      const Int3 at = out_.sites[static_cast<std::size_t>(c_.cellVertex(cell, base))];
      const auto& tet = lattice.tetPlacements[c_.cellFrames[cell]];
      const auto& oct = lattice.octPlacements[c_.cellFrames[cell]];
      Int3 sum{};
      for (int i = 0; i < n; ++i) {
        const auto hop = n == 4 ? tet.neighbour[base][i] : oct.neighbour[base][i];
        const Int3 site = i == base ? at : at + lattice.neighbours[hop];
        const auto v = static_cast<std::size_t>(c_.cellVertex(cell, i));
        out_.sites[v] = site;
        known[v] = 1;
        sum = sum + site;
        c_.visitVertexStar(c_.cellVertex(cell, i), [&](const CellAtVertex& other) {
          auto& flag = seen[static_cast<std::size_t>(other.cell)];
          if (!flag) queue.push_back(other.cell);
          flag = 1;
        });
      }
      if (n == 6) octs_.insert({sum[0] / 6, sum[1] / 6, sum[2] / 6});
      if (n == 4) tets_.insert(cubeOf(cell));
    }
    for (std::size_t v = 0; v < known.size(); ++v) {
      if (known[v]) out_.atSite.emplace(out_.sites[v], static_cast<Index>(v));
    }
    return queue.size() == static_cast<std::size_t>(c_.cellCount());
  }

  Int3 cubeOf(Index tet) const {
    Int3 low = out_.sites[static_cast<std::size_t>(c_.cellVertex(tet, 0))];
    for (int i = 1; i < 4; ++i) {
      const Int3& p = out_.sites[static_cast<std::size_t>(c_.cellVertex(tet, i))];
      for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]);
    }
    return low;
  }

  Index vertexAt(const Int3& site) {
    const auto [it, added] = out_.atSite.emplace(site, static_cast<Index>(out_.sites.size()));
    if (added) out_.sites.push_back(site);
    return it->second;
  }

  /// Adds the cells that the lattice has at a site and the mesh has not.
  void completeStar(const Int3 site) {
    for (int k = 0; k < 8; ++k) {
      const Int3 cube = site - Int3{k >> 2 & 1, k >> 1 & 1, k & 1};
      if (!tets_.insert(cube).second) continue;
      auto& tet = out_.expanded.tets.emplace_back();
      const auto corners = tetAt(cube);
      for (int i = 0; i < 4; ++i) tet[i] = vertexAt(corners[i]);
    }
    for (int k = 0; k < 6; ++k) {
      Int3 centre = site;
      centre[k / 2] += k % 2 ? 1 : -1;
      if (!octs_.insert(centre).second) continue;
      auto& oct = out_.expanded.octs.emplace_back();
      const auto corners = octAt(centre);
      for (int i = 0; i < 6; ++i) oct[i] = vertexAt(corners[i]);
    }
  }

  /// Combinations of least norm over the real cells around a site.
  void placeVertices() {
    const std::size_t real = static_cast<std::size_t>(c_.vertexCount());
    out_.vertices.resize(out_.sites.size() - real);
    const Lattice& lattice = Lattice::get();
    parallelFor<std::size_t>(
        out_.vertices.size(),
        [&](std::size_t k) {
          const Int3& site = out_.sites[real + k];
          std::set<Index> around;
          for (int hop = 0; hop < kNeighbours; ++hop) {
            const auto found = out_.atSite.find(site + lattice.neighbours[hop]);
            if (found == out_.atSite.end() || found->second >= c_.vertexCount()) continue;
            c_.visitVertexStar(found->second, [&](const CellAtVertex& at) {
              for (int i = 0; i < c_.cellVertexCount(at.cell); ++i) {
                around.insert(c_.cellVertex(at.cell, i));
              }
            });
          }
          out_.vertices[k] = leastNorm(site, {around.begin(), around.end()});
        },
        16);
  }

  /// Only the nearest vertices that span space count: those of one or a few cells.
  SparseChain leastNorm(const Int3& site, std::vector<Index> around) const {
    const auto distance = [&](Index v) {
      const Int3 p = out_.sites[static_cast<std::size_t>(v)] - site;
      return p[0] * p[0] + p[1] * p[1] + p[2] * p[2];
    };
    std::stable_sort(around.begin(), around.end(),
                     [&](Index a, Index b) { return distance(a) < distance(b); });
    constexpr int kNearest = 6;  // squared, from beside a cell to its far side
    for (int reach = kNearest;; reach *= 2) {
      const auto end = std::partition_point(around.begin(), around.end(),
                                            [&](Index v) { return distance(v) <= reach; });
      const auto n = static_cast<Eigen::Index>(end - around.begin());
      Eigen::MatrixXd rows(4, n);
      for (Eigen::Index k = 0; k < n; ++k) {
        const Int3 p =
            out_.sites[static_cast<std::size_t>(around[static_cast<std::size_t>(k)])] - site;
        rows.col(k) << 1, p[0], p[1], p[2];
      }
      const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver(rows);
      if (solver.rank() < 4 && end != around.end()) continue;
      const Eigen::VectorXd weights = solver.solve(Eigen::Vector4d(1, 0, 0, 0));
      SparseChain result;
      for (Eigen::Index k = 0; k < n; ++k) {
        if (std::abs(weights[k]) > 1e-14) {
          result.emplace_back(around[static_cast<std::size_t>(k)], weights[k]);
        }
      }
      return result;
    }
  }

  const Complex& c_;
  VirtualLayer& out_;
  std::set<Int3> tets_, octs_;
};

// ---- any other mesh ----------------------------------------------------------------------------

SparseChain combined(std::initializer_list<std::pair<double, const SparseChain*>> terms) {
  std::map<Index, double> sum;
  for (const auto& [weight, chain] : terms) {
    for (const auto& [v, w] : *chain) sum[v] += weight * w;
  }
  return {sum.begin(), sum.end()};
}

class GeneralLayer {
 public:
  GeneralLayer(const ControlMesh& mesh, VirtualLayer* out)
      : c_(*mesh.complex()), out_(*out), facetSlots_(static_cast<std::size_t>(c_.facetCount())) {}

  void run() {
    makeSlots();
    joinSlots();
    number();
    cellsOnFacets();
    cellsBetween();
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      if (c_.vertexOnBoundary(v)) openLinks_[v];
    }
    findOpenLinks();
    for (auto& [v, edges] : openLinks_) closeStar(v, edges);
  }

 private:
  /// A virtual vertex before neighbours have shared it: outside an edge of a facet, or its apex.
  struct Slot {
    SparseChain place;
    int parent;
  };
  /// Two boundary facets that follow each other around an edge outside the mesh.
  struct Gap {
    Index a, b;         // the edge
    int first, second;  // slots
    bool octahedron;    // what goes between; else a tetrahedron
  };

  bool tetInside(Index facet) const { return c_.isTet(inner(facet).cell()); }
  CellSide inner(Index facet) const {
    return c_.facetCells[facet][c_.facetCells[facet][0].exists() ? 0 : 1];
  }

  int newSlot(SparseChain place) {
    slots_.push_back({std::move(place), static_cast<int>(slots_.size())});
    return slots_.back().parent;
  }
  int root(int slot) {
    while (slots_[slot].parent != slot) slot = slots_[slot].parent;
    return slot;
  }

  /// By parallelograms of the facet's own cell.
  void makeSlots() {
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      const auto v = c_.facetVertices(f);
      const Index cell = inner(f).cell();
      auto& slots = facetSlots_[static_cast<std::size_t>(f)];
      if (tetInside(f)) {
        Index far = kNone;
        for (const Index x : c_.tets[cell]) {
          if (std::find(v.begin(), v.end(), x) == v.end()) far = x;
        }
        for (int k = 0; k < 3; ++k) {
          slots[k] = newSlot({{v[(k + 1) % 3], 1.0}, {v[(k + 2) % 3], 1.0}, {far, -1.0}});
        }
      } else {
        SparseChain apex;
        for (const Index x : c_.octs[cell - c_.tetCount()]) {
          const bool onFacet = std::find(v.begin(), v.end(), x) != v.end();
          apex.emplace_back(x, onFacet ? 2.0 / 3 : -1.0 / 3);
        }
        slots[0] = slots[1] = slots[2] = newSlot(apex);
      }
    }
  }

  /// Around every boundary edge, from a boundary facet through the mesh to the next one.
  void joinSlots() {
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      const auto v = c_.facetVertices(f);
      for (int k = 0; k < 3; ++k) {
        const Index a = v[(k + 1) % 3], b = v[(k + 2) % 3];
        const auto [g, cells] = across(f, c_.facetEdges[f][(k + 1) % 3].index());
        if (g < f) continue;
        const auto w = c_.facetVertices(g);
        int third = 0;
        while (w[third] == a || w[third] == b) ++third;
        join({a, b, facetSlots_[static_cast<std::size_t>(f)][k],
              facetSlots_[static_cast<std::size_t>(g)][third], false},
             tetInside(f), tetInside(g), cells);
      }
    }
  }

  /// The boundary facet on the other side of the mesh at an edge, and the number of cells between.
  std::pair<Index, int> across(Index facet, Index edge) const {
    Index at = facet;
    CellSide side = inner(facet);
    for (int cells = 1;; ++cells) {
      const Index cell = side.cell();
      for (int k = 0; k < c_.cellFacetCount(cell); ++k) {
        const Index other = c_.cellFacet(cell, k).index();
        if (other == at) continue;
        const auto& edges = c_.facetEdges[other];
        if (std::none_of(edges.begin(), edges.end(),
                         [&](const EdgeRef& e) { return e.index() == edge; })) {
          continue;
        }
        at = other;
        break;
      }
      if (c_.facetOnBoundary(at)) return {at, cells};
      const auto& sides = c_.facetCells[at];
      side = sides[0].cell() == cell ? sides[1] : sides[0];
    }
  }

  void join(Gap gap, bool firstTet, bool secondTet, int cells) {
    if (firstTet == secondTet && (cells == 1 || !firstTet)) {
      gap.octahedron = !firstTet && cells == 1;
      gaps_.push_back(gap);
      return;
    }
    // Outside a tetrahedron's and an octahedron's facet, or between two octahedra outside: shared.
    const int a = root(gap.first), b = root(gap.second);
    if (a != b) slots_[std::max(a, b)].parent = std::min(a, b);
  }

  /// Virtual vertices at the mean of what shares them.
  void number() {
    slotVertex_.assign(slots_.size(), kNone);
    std::vector<std::vector<int>> members(slots_.size());
    for (int s = 0; s < static_cast<int>(slots_.size()); ++s) members[root(s)].push_back(s);
    for (std::size_t s = 0; s < slots_.size(); ++s) {
      if (members[s].empty()) continue;
      std::map<Index, double> sum;
      for (const int m : members[s]) {
        for (const auto& [v, w] : slots_[m].place)
          sum[v] += w / static_cast<double>(members[s].size());
      }
      const Index vertex = newVertex({sum.begin(), sum.end()});
      for (const int m : members[s]) slotVertex_[m] = vertex;
    }
  }

  Index newVertex(SparseChain place) {
    out_.vertices.push_back(std::move(place));
    return c_.vertexCount() + static_cast<Index>(out_.vertices.size()) - 1;
  }
  SparseChain place(Index v) const {
    if (v < c_.vertexCount()) return {{v, 1.0}};
    return out_.vertices[static_cast<std::size_t>(v - c_.vertexCount())];
  }

  void cellsOnFacets() {
    for (Index f = 0; f < c_.facetCount(); ++f) {
      if (!c_.facetOnBoundary(f)) continue;
      const auto v = c_.facetVertices(f);
      const auto& s = facetSlots_[static_cast<std::size_t>(f)];
      const auto at = [&](int k) { return slotVertex_[s[k]]; };
      if (tetInside(f)) {
        addOct({v[0], v[1], v[2], at(1), at(2), at(0)});
      } else {
        addTet({v[0], v[1], v[2], at(0)});
      }
    }
  }

  void cellsBetween() {
    for (const Gap& gap : gaps_) {
      const Index p = slotVertex_[gap.first], q = slotVertex_[gap.second];
      if (!gap.octahedron) {
        addTet({gap.a, gap.b, p, q});
        continue;
      }
      const SparseChain a = place(gap.a), b = place(gap.b), atP = place(p), atQ = place(q);
      const Index farA = newVertex(combined({{1, &atP}, {1, &atQ}, {-1, &a}}));
      const Index farB = newVertex(combined({{1, &atP}, {1, &atQ}, {-1, &b}}));
      addOct({gap.a, gap.b, p, farB, q, farA});
    }
  }

  template <typename Shape, typename Cell>
  void countFacets(const Cell& cell) {
    for (const auto& f : Shape::facets) {
      std::array<Index, 3> key = {cell[f[0]], cell[f[1]], cell[f[2]]};
      std::sort(key.begin(), key.end());
      ++uses_[key];
    }
  }
  void addTet(const std::array<Index, 4>& tet) {
    out_.expanded.tets.push_back(tet);
    countFacets<Tetrahedron>(tet);
  }
  void addOct(const std::array<Index, 6>& oct) {
    out_.expanded.octs.push_back(oct);
    countFacets<Octahedron>(oct);
  }

  /// Virtual facets with one real vertex that have one cell so far, as edges of its open link.
  void findOpenLinks() {
    for (const auto& [facet, count] : uses_) {
      if (count != 1) continue;
      if (facet[0] < c_.vertexCount() && facet[1] >= c_.vertexCount()) {
        openLinks_[facet[0]].emplace_back(facet[1], facet[2]);
      }
    }
  }

  void closeStar(Index v, std::vector<std::pair<Index, Index>> edges) {
    while (!edges.empty()) {
      std::vector<Index> loop = {edges.back().first, edges.back().second};
      edges.pop_back();
      while (loop.front() != loop.back()) {
        const auto next = std::find_if(edges.begin(), edges.end(), [&](const auto& e) {
          return e.first == loop.back() || e.second == loop.back();
        });
        if (next == edges.end()) {
          throw InputError("boundary", "cannot be expanded at vertex " + std::to_string(v) +
                                           ", where it touches itself");
        }
        loop.push_back(next->first == loop.back() ? next->second : next->first);
        edges.erase(next);
      }
      loop.pop_back();
      closeLoop(v, loop);
    }
  }

  void closeLoop(Index v, const std::vector<Index>& loop) {
    std::map<Index, double> mean;
    for (const Index p : loop) {
      for (const auto& [x, w] : place(p)) mean[x] += w / static_cast<double>(loop.size());
    }
    const SparseChain middle(mean.begin(), mean.end()), centre = place(v);
    if (loop.size() == 3) {
      addTet({v, loop[0], loop[1], loop[2]});
    } else if (loop.size() == 4) {
      const Index far = newVertex(combined({{2, &middle}, {-1, &centre}}));
      addOct({v, loop[0], loop[1], loop[2], loop[3], far});
    } else {
      // Further out than the loop, as far as the vertex is from its real neighbours.
      std::map<Index, double> neighbours;
      int cells = 0;
      c_.visitVertexStar(v, [&](const CellAtVertex&) { ++cells; });
      c_.visitVertexStar(v, [&](const CellAtVertex& at) {
        const int n = c_.cellVertexCount(at.cell);
        for (int i = 0; i < n; ++i) {
          neighbours[c_.cellVertex(at.cell, i)] += 1.0 / (static_cast<double>(n) * cells);
        }
      });
      const SparseChain inside(neighbours.begin(), neighbours.end());
      const Index tip = newVertex(combined({{1, &middle}, {1, &centre}, {-1, &inside}}));
      for (std::size_t k = 0; k < loop.size(); ++k) {
        addTet({v, loop[k], loop[(k + 1) % loop.size()], tip});
      }
    }
  }

  const Complex& c_;
  VirtualLayer& out_;
  std::vector<std::array<int, 3>> facetSlots_;  // by the vertex opposite
  std::vector<Slot> slots_;
  std::vector<Index> slotVertex_;
  std::vector<Gap> gaps_;
  std::map<std::array<Index, 3>, int> uses_;
  std::map<Index, std::vector<std::pair<Index, Index>>> openLinks_;
};

// ---- orientation -------------------------------------------------------------------------------

/// Cell signs of all cells, spreading from the real ones across facets.
class Orientation {
 public:
  explicit Orientation(const ControlMeshInput& mesh) : mesh_(mesh) {
    const std::size_t tets = mesh.tets.size();
    for (std::size_t k = 0; k < tets; ++k) list<Tetrahedron>(mesh.tets[k], k);
    for (std::size_t k = 0; k < mesh.octs.size(); ++k) list<Octahedron>(mesh.octs[k], tets + k);
  }

  void spread(Array<std::int8_t>* signs) const {
    std::vector<std::size_t> queue;
    for (std::size_t k = 0; k < signs->size(); ++k) {
      if ((*signs)[k] != 0) queue.push_back(k);
    }
    for (std::size_t k = 0; k < queue.size(); ++k) {
      visitFacets(queue[k], [&](const std::array<Index, 3>& key, int parity) {
        for (const auto& [other, otherParity] : sides_.at(key)) {
          if (other == queue[k]) continue;
          // Outward of one cell is inward of the other.
          const auto wanted = static_cast<std::int8_t>(-(*signs)[queue[k]] * parity * otherParity);
          if ((*signs)[other] == 0) {
            (*signs)[other] = wanted;
            queue.push_back(other);
          } else if ((*signs)[other] != wanted) {
            throw InputError("boundary", "cannot be expanded: its layer would be one-sided");
          }
        }
      });
    }
  }

 private:
  template <typename Shape, typename Cell, typename Visit>
  static void visit(const Cell& cell, const Visit& visitor) {
    for (const auto& f : Shape::facets) {
      std::array<Index, 3> key = {cell[f[0]], cell[f[1]], cell[f[2]]};
      int parity = 1;
      for (int i = 0; i < 3; ++i) {
        for (int j = i + 1; j < 3; ++j) {
          if (key[i] > key[j]) parity = -parity;
        }
      }
      std::sort(key.begin(), key.end());
      visitor(key, parity);
    }
  }
  template <typename Visit>
  void visitFacets(std::size_t cell, const Visit& visitor) const {
    if (cell < mesh_.tets.size()) {
      visit<Tetrahedron>(mesh_.tets[cell], visitor);
    } else {
      visit<Octahedron>(mesh_.octs[cell - mesh_.tets.size()], visitor);
    }
  }
  template <typename Shape, typename Cell>
  void list(const Cell& cell, std::size_t number) {
    visit<Shape>(cell, [&](const std::array<Index, 3>& key, int parity) {
      sides_[key].emplace_back(number, parity);
    });
  }

  const ControlMeshInput& mesh_;
  std::map<std::array<Index, 3>, std::vector<std::pair<std::size_t, int>>> sides_;
};

}  // namespace

VirtualLayer::VirtualLayer(const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  expanded.tets = c.tets;
  expanded.octs = c.octs;
  expanded.creases.emplace();
  if (!LatticeLayer(mesh, this).run()) {
    sites.clear();
    atSite.clear();
    GeneralLayer(mesh, this).run();
  }
  expanded.vertices = mesh.positions();
  for (const SparseChain& chain : vertices) {
    Vec3 place = Vec3::Zero();
    for (const auto& [v, w] : chain) place += w * mesh.positions()[v];
    expanded.vertices.push_back(place);
  }
  expanded.cellSigns.assign(expanded.tets.size() + expanded.octs.size(), 0);
  for (Index cell = 0; cell < c.cellCount(); ++cell) {
    const std::size_t place =
        c.isTet(cell) ? static_cast<std::size_t>(cell)
                      : expanded.tets.size() + static_cast<std::size_t>(cell - c.tetCount());
    expanded.cellSigns[place] = c.cellSigns[cell];
  }
  Orientation(expanded).spread(&expanded.cellSigns);
}

}  // namespace octet
