// SPDX-License-Identifier: Apache-2.0
#include "surfaces.h"

#include <cmath>

#include "meshes.h"

namespace octet::testing {
namespace {

Vec3 direction(double u, double v) {
  return {std::sin(u) * std::cos(v), std::sin(u) * std::sin(v), std::cos(u)};
}

/// Walls and two caps over a polygon whose triangles are given.
TriangleSurface prism(const std::vector<std::array<double, 2>>& polygon,
                      const std::vector<std::array<Index, 3>>& cap, double height) {
  TriangleSurface s;
  const Index n = static_cast<Index>(polygon.size());
  for (const double z : {0.0, height}) {
    for (const auto& [x, y] : polygon) s.vertices.emplace_back(x, y, z);
  }
  for (const auto& [a, b, c] : cap) {
    s.triangles.push_back({a, c, b});
    s.triangles.push_back({a + n, b + n, c + n});
  }
  for (Index i = 0; i < n; ++i) {
    const Index j = (i + 1) % n;
    s.triangles.push_back({i, j, j + n});
    s.triangles.push_back({i, j + n, i + n});
  }
  return s;
}

}  // namespace

TriangleSurface surfaceOf(int n, int m, bool sphere,
                          const std::function<Vec3(double, double)>& at) {
  TriangleSurface s;
  const int rows = sphere ? n - 1 : n;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < m; ++j) {
      const double u = sphere ? M_PI * (i + 1) / n : 2 * M_PI * i / n;
      s.vertices.push_back(at(u, 2 * M_PI * j / m));
    }
  }
  const auto id = [&](int i, int j) { return static_cast<Index>((i % rows) * m + j % m); };
  for (int i = 0; i < (sphere ? rows - 1 : rows); ++i) {
    for (int j = 0; j < m; ++j) {
      s.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      s.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  if (!sphere) return s;
  const Index top = static_cast<Index>(s.vertices.size()), bottom = top + 1;
  s.vertices.push_back(at(0, 0));
  s.vertices.push_back(at(M_PI, 0));
  for (int j = 0; j < m; ++j) {
    s.triangles.push_back({top, id(0, j), id(0, j + 1)});
    s.triangles.push_back({bottom, id(rows - 1, j + 1), id(rows - 1, j)});
  }
  return s;
}

TriangleSurface ball(double radius, const Vec3& centre, int n) {
  return surfaceOf(n, 2 * n, true,
                   [&](double u, double v) -> Vec3 { return centre + radius * direction(u, v); });
}

TriangleSurface torus() {
  return surfaceOf(64, 32, false, [](double u, double v) {
    const double r = 1 + 0.35 * std::cos(v);
    return Vec3(r * std::cos(u), r * std::sin(u), 0.35 * std::sin(v));
  });
}

TriangleSurface blob(std::uint32_t seed) {
  const auto r = randomValues(24, seed);
  return surfaceOf(48, 96, true, [r](double u, double v) -> Vec3 {
    const Vec3 p = direction(u, v);
    double radius = 1;
    for (int k = 0; k < 6; ++k) {
      const Vec3 q(r[4 * k], r[4 * k + 1], r[4 * k + 2]);
      radius += 0.09 * std::sin(4 * q.dot(p) + 3 * r[4 * k + 3]);
    }
    return radius * p;
  });
}

TriangleSurface bunnyLike() {
  struct Bump {
    Vec3 towards;
    double height, width;
  };
  const Bump bumps[] = {{{0.3, 0.35, 1}, 1.1, 0.22},  // ears
                        {{0.3, -0.35, 1}, 1.1, 0.22},
                        {{1, 0, 0.3}, 0.35, 0.5},    // nose
                        {{-1, 0, -0.4}, 0.3, 0.3}};  // tail
  return surfaceOf(96, 192, true, [&](double u, double v) -> Vec3 {
    const Vec3 p = direction(u, v);
    double radius = 1;
    for (const Bump& bump : bumps) {
      const double angle = std::acos(std::min(1.0, p.dot(bump.towards.normalized())));
      radius += bump.height * std::exp(-std::pow(angle / bump.width, 2));
    }
    return radius * p;
  });
}

Box boxOf(const Vec3& a, const Vec3& b) {
  Box box;
  box.extend(a);
  box.extend(b);
  return box;
}

TriangleSurface ellSurface() {
  return prism({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}},
               {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 1);
}

TriangleSurface cylinder(double radius, double height, int n) {
  std::vector<std::array<double, 2>> circle;
  std::vector<std::array<Index, 3>> fan;
  for (int i = 0; i < n; ++i) {
    circle.push_back({radius * std::cos(2 * M_PI * i / n), radius * std::sin(2 * M_PI * i / n)});
    if (i > 1) fan.push_back({0, i - 1, i});
  }
  return prism(circle, fan, height);
}

TriangleSurface joined(TriangleSurface a, const TriangleSurface& b, bool reversed) {
  const Index first = static_cast<Index>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (auto t : b.triangles) {
    for (Index& v : t) v += first;
    if (reversed) std::swap(t[0], t[1]);
    a.triangles.push_back(t);
  }
  return a;
}

double volumeOf(const ControlMesh& mesh) {
  double volume = 0;
  for (Index cell = 0; cell < mesh.complex()->cellCount(); ++cell) {
    volume += std::abs(cellVolume6(*mesh.complex(), mesh.positions(), cell)) / 6;
  }
  return volume;
}

}  // namespace octet::testing
