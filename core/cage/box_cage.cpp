// SPDX-License-Identifier: Apache-2.0
#include "box_cage.h"

#include <algorithm>
#include <cmath>

#include "../base/error.h"
#include "../rules/lattice.h"

namespace octet {
namespace {

constexpr Int3 kOctahedron[6] = {{0, 0, 1},  {1, 0, 0},  {0, 1, 0},
                                 {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};

class BoxFiller {
 public:
  BoxFiller(const Box& box, double spacing) : box_(box) {
    if (box.empty() || !box.size().allFinite() || !(box.size().minCoeff() > 0)) {
      throw InputError("box", "is empty or not finite");
    }
    if (!(spacing > 0) || !std::isfinite(spacing)) {
      throw InputError("spacing", "is not a positive number");
    }
    double cells = 1.5;
    for (int k = 0; k < 3; ++k) {
      const double layers =
          2 * std::max(1.0, std::round(box.size()[k] / (std::sqrt(2.0) * spacing)));
      cells *= layers;
      n_[k] = static_cast<int>(std::min(layers, 1e9));
    }
    if (cells > static_cast<double>(kMostCageCells)) {
      throw InputError("spacing",
                       "is too fine: it makes some " +
                           std::to_string(static_cast<std::int64_t>(std::min(cells, 9e18))) +
                           " cells");
    }
  }

  ControlMeshInput run() {
    mesh_.creases.emplace();
    numbers_.assign(static_cast<std::size_t>(n_[0] + 1) * (n_[1] + 1) * (n_[2] + 1), kNone);
    for (int i = 0; i <= n_[0]; ++i) {
      for (int j = 0; j <= n_[1]; ++j) {
        for (int k = 0; k <= n_[2]; ++k) addAt({i, j, k});
      }
    }
    return std::move(mesh_);
  }

 private:
  bool isOdd(const Int3& p) const { return (p[0] + p[1] + p[2]) & 1; }
  bool inside(const Int3& p, int k) const { return p[k] >= 0 && p[k] <= n_[k]; }

  /// The tetrahedron of the unit cube at p, and what is left of the octahedron around p.
  void addAt(const Int3& p) {
    if (p[0] < n_[0] && p[1] < n_[1] && p[2] < n_[2]) {
      auto& tet = mesh_.tets.emplace_back();
      int n = 0;
      for (int corner = 0; corner < 8; ++corner) {
        const Int3 q = {p[0] + (corner >> 2), p[1] + (corner >> 1 & 1), p[2] + (corner & 1)};
        if (!isOdd(q)) tet[n++] = number(q);
      }
    }
    int walls = 0;
    for (int k = 0; k < 3; ++k) walls += p[k] == 0 || p[k] == n_[k];
    if (!isOdd(p)) return addCreases(p, walls);
    if (walls < 2) return addOctahedron(p);
    // On the box' edge: a quarter of an octahedron. Corners are even points.
    auto& tet = mesh_.tets.emplace_back();
    int n = 0;
    for (const Int3& step : kOctahedron) {
      const Int3 q = {p[0] + step[0], p[1] + step[1], p[2] + step[2]};
      if (inside(q, 0) && inside(q, 1) && inside(q, 2)) tet[n++] = number(q);
    }
  }

  /// A pole beyond a wall is put into it, where the octahedron's centre is.
  void addOctahedron(const Int3& p) {
    auto& oct = mesh_.octs.emplace_back();
    for (int i = 0; i < 6; ++i) {
      Int3 q = {p[0] + kOctahedron[i][0], p[1] + kOctahedron[i][1], p[2] + kOctahedron[i][2]};
      for (int k = 0; k < 3; ++k) q[k] = std::clamp(q[k], 0, n_[k]);
      oct[i] = number(q);
    }
  }

  /// Edges of the box run between even points two apart.
  void addCreases(const Int3& p, int walls) {
    if (walls < 2) return;
    for (int k = 0; k < 3; ++k) {
      Int3 q = p;
      q[k] += 2;
      const int others = (p[(k + 1) % 3] == 0 || p[(k + 1) % 3] == n_[(k + 1) % 3]) +
                         (p[(k + 2) % 3] == 0 || p[(k + 2) % 3] == n_[(k + 2) % 3]);
      if (others == 2 && inside(q, k)) mesh_.creases->push_back({number(p), number(q)});
    }
  }

  Index number(const Int3& p) {
    const std::size_t at =
        (static_cast<std::size_t>(p[0]) * (n_[1] + 1) + p[1]) * (n_[2] + 1) + p[2];
    if (numbers_[at] == kNone) {
      numbers_[at] = static_cast<Index>(mesh_.vertices.size());
      Vec3 x;
      // Exact at both ends, so that walls are planes to the bit.
      for (int k = 0; k < 3; ++k) {
        const double t = static_cast<double>(p[k]) / n_[k];
        x[k] = (1 - t) * box_.min[k] + t * box_.max[k];
      }
      mesh_.vertices.push_back(x);
    }
    return numbers_[at];
  }

  Box box_;
  Int3 n_{};
  ControlMeshInput mesh_;
  Array<Index> numbers_;
};

}  // namespace

ControlMeshInput boxCage(const Box& box, double spacing) { return BoxFiller(box, spacing).run(); }

}  // namespace octet
