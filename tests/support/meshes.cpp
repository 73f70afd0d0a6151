// SPDX-License-Identifier: Apache-2.0
#include "meshes.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <octet/core/rules/lattice.h>

namespace octet::testing {
namespace {

using Tet = std::array<Index, 4>;
using Oct = std::array<Index, 6>;

/// The same numbers with every standard library, unlike its distributions.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (engine_() / 4294967296.0);
  }
  Vec3 inBox(double half) {
    const double x = uniform(-half, half), y = uniform(-half, half);
    return {x, y, uniform(-half, half)};
  }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(uniform(0, n)); }

 private:
  std::mt19937 engine_;
};

template <typename T>
void shuffle(std::vector<T>* list, Random* random) {
  for (std::size_t k = list->size(); k > 1; --k) {
    std::swap((*list)[k - 1], (*list)[random->below(static_cast<std::uint32_t>(k))]);
  }
}

/// Keeps only vertices that some cell uses.
void dropUnusedVertices(ControlMeshInput* mesh) {
  std::vector<Index> newIndex(mesh->vertices.size(), kNone);
  Array<Vec3> kept;
  const auto renumber = [&](auto& cells) {
    for (auto& cell : cells) {
      for (Index& v : cell) {
        if (newIndex[v] == kNone) {
          newIndex[v] = static_cast<Index>(kept.size());
          kept.push_back(mesh->vertices[v]);
        }
        v = newIndex[v];
      }
    }
  };
  renumber(mesh->tets);
  renumber(mesh->octs);
  mesh->vertices = std::move(kept);
}

double volume6(const Array<Vec3>& x, const Tet& t) {
  return (x[t[1]] - x[t[0]]).dot((x[t[2]] - x[t[0]]).cross(x[t[3]] - x[t[0]]));
}

/// Bowyer-Watson: all tetrahedra whose circumsphere holds the new point go, the hole is starred.
std::vector<Tet> delaunay(const std::vector<Vec3>& points) {
  Array<Vec3> x(points.begin(), points.end());
  const Index n = static_cast<Index>(points.size());
  for (const Vec3& p : {Vec3(-1e3, -1e3, -1e3), Vec3(3e3, -1e3, -1e3), Vec3(-1e3, 3e3, -1e3),
                        Vec3(-1e3, -1e3, 3e3)}) {
    x.push_back(p);
  }
  struct Ball {
    Tet tet;
    Vec3 centre;
    double radius2;
  };
  const auto make = [&](Tet t) {
    if (volume6(x, t) < 0) std::swap(t[0], t[1]);
    Eigen::Matrix3d a;
    Vec3 b;
    for (int k = 0; k < 3; ++k) {
      const Vec3 edge = x[t[k + 1]] - x[t[0]];
      a.row(k) = edge;
      b[k] = edge.squaredNorm() / 2;
    }
    const Vec3 centre = a.fullPivLu().solve(b);
    return Ball{t, x[t[0]] + centre, centre.squaredNorm()};
  };
  std::vector<Ball> balls = {make({n, n + 1, n + 2, n + 3})};
  for (Index p = 0; p < n; ++p) {
    std::map<std::array<Index, 3>, int> facets;
    std::vector<Ball> kept;
    for (const Ball& ball : balls) {
      if ((x[p] - ball.centre).squaredNorm() > ball.radius2) {
        kept.push_back(ball);
        continue;
      }
      for (int skip = 0; skip < 4; ++skip) {
        std::array<Index, 3> f;
        int m = 0;
        for (int i = 0; i < 4; ++i) {
          if (i != skip) f[m++] = ball.tet[i];
        }
        std::sort(f.begin(), f.end());
        ++facets[f];
      }
    }
    for (const auto& [f, count] : facets) {
      if (count == 1) kept.push_back(make({f[0], f[1], f[2], p}));
    }
    balls = std::move(kept);
  }
  std::vector<Tet> tets;
  for (const Ball& ball : balls) {
    if (std::all_of(ball.tet.begin(), ball.tet.end(), [&](Index v) { return v < n; })) {
      tets.push_back(ball.tet);
    }
  }
  return tets;
}

}  // namespace

std::vector<double> randomValues(Index count, std::uint32_t seed) {
  Random random(seed);
  std::vector<double> values(count);
  for (double& x : values) x = random.uniform(-1, 1);
  return values;
}

ControlMeshInput singleTetrahedron() {
  ControlMeshInput mesh;
  for (const Int3& p : canonicalPoints<Tetrahedron>()) mesh.vertices.emplace_back(p[0], p[1], p[2]);
  mesh.tets = {{0, 1, 2, 3}};
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput singleOctahedron(bool concave) {
  ControlMeshInput mesh;
  for (const Int3& p : canonicalPoints<Octahedron>()) mesh.vertices.emplace_back(p[0], p[1], p[2]);
  if (concave) mesh.vertices[1] = Vec3(-0.3, 0.1, 0);
  mesh.octs = {{0, 1, 2, 3, 4, 5}};
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput tetrahedraAroundEdge(int n) {
  ControlMeshInput mesh;
  mesh.vertices = {Vec3(0, 0, -1), Vec3(0.1, 0, 1.1)};
  for (int k = 0; k < n; ++k) {
    const double turn = 2 * 3.14159265358979323846 * k / n;
    mesh.vertices.emplace_back(std::cos(turn), std::sin(turn), 0.07 * k);
    mesh.tets.push_back({0, 1, 2 + k, 2 + (k + 1) % n});
  }
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput creasedBox(int n, double jitter, std::uint32_t seed) {
  ControlMeshInput mesh;
  Random random(seed);
  const auto id = [&](int i, int j, int k) { return (i * (n + 1) + j) * (n + 1) + k; };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      for (int k = 0; k <= n; ++k) {
        const bool inner = i % n != 0 && j % n != 0 && k % n != 0;
        const Vec3 move = random.inBox(jitter);
        mesh.vertices.push_back(Vec3(i, j, k) + (inner ? move : Vec3::Zero()));
      }
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        std::array<int, 3> axes = {0, 1, 2};
        do {
          std::array<int, 3> at = {i, j, k};
          Tet tet = {id(i, j, k), 0, 0, 0};
          for (int a = 0; a < 3; ++a) {
            ++at[axes[a]];
            tet[a + 1] = id(at[0], at[1], at[2]);
          }
          mesh.tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return mesh;  // the default creases are the box' edges
}

ControlMeshInput randomBall(int points, std::uint32_t seed) {
  Random random(seed);
  // Points that keep a distance make cells of moderate shape; those on the sphere come first.
  const double spacing = 1.6 / std::cbrt(static_cast<double>(points));
  std::vector<Vec3> chosen;
  for (int tries = 0; tries < 200 * points && static_cast<int>(chosen.size()) < points; ++tries) {
    Vec3 p = random.inBox(1);
    const double r = p.norm();
    if (r > 1 || r < 0.1) continue;
    const bool surface = static_cast<int>(chosen.size()) < points / 3;
    // Not exactly on the sphere: cospherical points have no one triangulation.
    if (surface) p *= (1 - random.uniform(0, 0.04)) / r;
    if (!surface && r > 1 - spacing / 2) continue;
    const bool far = std::all_of(chosen.begin(), chosen.end(), [&](const Vec3& q) {
      return (p - q).norm() > (surface ? 1.1 : 0.8) * spacing;
    });
    if (far) chosen.push_back(p);
  }
  ControlMeshInput mesh;
  mesh.vertices.assign(chosen.begin(), chosen.end());
  for (const Tet& t : delaunay(chosen)) {
    double longest = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) longest = std::max(longest, (chosen[t[i]] - chosen[t[j]]).norm());
    }
    if (std::abs(volume6(mesh.vertices, t)) > 0.03 * std::pow(longest, 3)) mesh.tets.push_back(t);
  }
  dropUnusedVertices(&mesh);
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput withOctahedra(ControlMeshInput mesh) {
  std::map<std::array<Index, 2>, std::vector<std::size_t>> stars;
  for (std::size_t k = 0; k < mesh.tets.size(); ++k) {
    const Tet& t = mesh.tets[k];
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        stars[{std::min(t[i], t[j]), std::max(t[i], t[j])}].push_back(k);
      }
    }
  }
  std::vector<bool> gone(mesh.tets.size(), false);
  for (const auto& [edge, star] : stars) {
    if (star.size() != 4) continue;
    if (std::any_of(star.begin(), star.end(), [&](std::size_t k) { return gone[k]; })) continue;
    // The other two vertices of each tetrahedron, chained to a ring.
    std::vector<std::array<Index, 2>> links;
    for (const std::size_t k : star) {
      std::array<Index, 2> link;
      int n = 0;
      for (const Index v : mesh.tets[k]) {
        if (v != edge[0] && v != edge[1]) link[n++] = v;
      }
      links.push_back(link);
    }
    std::vector<Index> ring = {links[0][0], links[0][1]};
    std::vector<bool> used = {true, false, false, false};
    for (int step = 0; step < 3; ++step) {
      for (int k = 0; k < 4; ++k) {
        if (used[k] || (links[k][0] != ring.back() && links[k][1] != ring.back())) continue;
        used[k] = true;
        ring.push_back(links[k][0] == ring.back() ? links[k][1] : links[k][0]);
        break;
      }
    }
    if (ring.size() != 5 || ring[0] != ring[4]) continue;
    for (const std::size_t k : star) gone[k] = true;
    mesh.octs.push_back({edge[0], ring[0], ring[1], ring[2], ring[3], edge[1]});
  }
  Array<Tet> kept;
  for (std::size_t k = 0; k < mesh.tets.size(); ++k) {
    if (!gone[k]) kept.push_back(mesh.tets[k]);
  }
  mesh.tets = std::move(kept);
  return mesh;
}

ControlMeshInput latticeBlock(const std::function<bool(int, int, int)>& inside, int radius,
                              double jitter, std::uint32_t seed) {
  const LatticePatch patch(radius);
  const auto keep = [&](const auto& cell) {
    return std::all_of(cell.begin(), cell.end(), [&](std::int32_t v) {
      const Int3& p = patch.points[v];
      return inside(p[0], p[1], p[2]);
    });
  };
  ControlMeshInput mesh;
  Random random(seed);
  for (const Int3& p : patch.points) {
    mesh.vertices.push_back(Vec3(p[0], p[1], p[2]) + random.inBox(jitter));
  }
  for (const auto& tet : patch.tets) {
    if (keep(tet)) mesh.tets.push_back(tet);
  }
  for (const auto& oct : patch.octs) {
    if (keep(oct)) mesh.octs.push_back(oct);
  }
  dropUnusedVertices(&mesh);
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput regularOneRing() {
  const LatticePatch patch(0);
  ControlMeshInput mesh;
  for (const Int3& p : patch.points) mesh.vertices.emplace_back(p[0], p[1], p[2]);
  mesh.tets.assign(patch.tets.begin(), patch.tets.end());
  mesh.octs.assign(patch.octs.begin(), patch.octs.end());
  mesh.creases.emplace();
  return mesh;
}

ControlMeshInput withHoles(ControlMeshInput mesh, double fraction, std::uint32_t seed) {
  Random random(seed);
  const auto thin = [&](auto& cells) {
    std::remove_reference_t<decltype(cells)> kept;
    for (const auto& cell : cells) {
      if (random.uniform(0, 1) > fraction) kept.push_back(cell);
    }
    cells = std::move(kept);
  };
  thin(mesh.tets);
  thin(mesh.octs);
  dropUnusedVertices(&mesh);
  return mesh;
}

ControlMeshInput shuffled(const ControlMeshInput& mesh, std::uint32_t seed) {
  Random random(seed);
  std::vector<Index> order(mesh.vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Index>(k);
  shuffle(&order, &random);
  ControlMeshInput result = mesh;
  for (std::size_t k = 0; k < order.size(); ++k) result.vertices[order[k]] = mesh.vertices[k];
  std::vector<Tet> tets(mesh.tets.begin(), mesh.tets.end());
  std::vector<Oct> octs(mesh.octs.begin(), mesh.octs.end());
  shuffle(&tets, &random);
  shuffle(&octs, &random);
  for (Tet& t : tets) {
    std::vector<Index> v(t.begin(), t.end());
    shuffle(&v, &random);
    for (int i = 0; i < 4; ++i) t[i] = order[v[i]];
  }
  for (Oct& o : octs) {
    // Any axis may be the pole, and the ring may start anywhere, either way round.
    std::vector<std::array<Index, 2>> axes = {{o[0], o[5]}, {o[1], o[3]}, {o[2], o[4]}};
    shuffle(&axes, &random);
    for (auto& axis : axes) {
      if (random.below(2)) std::swap(axis[0], axis[1]);
    }
    o = {order[axes[0][0]], order[axes[1][0]], order[axes[2][0]],
         order[axes[1][1]], order[axes[2][1]], order[axes[0][1]]};
  }
  result.tets.assign(tets.begin(), tets.end());
  result.octs.assign(octs.begin(), octs.end());
  if (result.creases) {
    for (auto& crease : *result.creases) crease = {order[crease[0]], order[crease[1]]};
  }
  for (Index& v : result.corners) v = order[v];
  return result;
}

std::vector<NamedMesh> allKinds() {
  const auto cube = [](int r) {
    return [r](int x, int y, int z) {
      return std::max({std::abs(x), std::abs(y), std::abs(z)}) <= r;
    };
  };
  const auto ball = [](int r2) {
    return [r2](int x, int y, int z) { return x * x + y * y + z * z <= r2; };
  };
  const auto notched = [](int x, int y, int z) {
    return std::max({std::abs(x), std::abs(y), std::abs(z)}) <= 3 && (x <= 0 || y <= 0 || z <= 0);
  };
  std::vector<NamedMesh> meshes;
  meshes.push_back({"tetrahedron", singleTetrahedron()});
  meshes.push_back({"octahedron", singleOctahedron()});
  meshes.push_back({"concave octahedron", singleOctahedron(true)});
  meshes.push_back({"five tetrahedra around an edge", tetrahedraAroundEdge(5)});
  meshes.push_back({"creased box", creasedBox(2, 0.1, 1)});
  meshes.push_back({"regular 1-ring", regularOneRing()});
  meshes.push_back({"lattice block", latticeBlock(cube(2), 2)});
  meshes.push_back({"deformed lattice", latticeBlock(ball(9), 3, 0.1, 2)});
  meshes.push_back({"notched lattice", latticeBlock(notched, 3)});
  meshes.push_back({"lattice with holes", withHoles(latticeBlock(cube(3), 3), 0.1, 3)});
  meshes.push_back({"random ball", randomBall(50, 4)});
  meshes.push_back({"mixed mesh", withOctahedra(randomBall(60, 5))});
  meshes.push_back({"mixed box", withOctahedra(creasedBox(3, 0.1, 6))});
  meshes.push_back({"mixed mesh with holes", withHoles(withOctahedra(randomBall(60, 7)), 0.1, 8)});
  return meshes;
}

std::vector<NamedMesh> randomMeshes() {
  std::vector<NamedMesh> meshes;
  for (std::uint32_t seed = 11; seed < 14; ++seed) {
    meshes.push_back({"ball " + std::to_string(seed), randomBall(100, seed)});
    meshes.push_back({"shuffled mixed ball " + std::to_string(seed),
                      shuffled(withOctahedra(randomBall(110, seed + 100)), seed)});
  }
  return meshes;
}

}  // namespace octet::testing
