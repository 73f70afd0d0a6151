// SPDX-License-Identifier: Apache-2.0
#include "edge_circulations.h"

#include <cmath>

#include "../field/piece.h"

namespace octet {

/// A piece's potential in barycentric coordinates: sum_i l_i linear_i + sum_i<j l_i l_j square_ij.
class EdgeCirculations::Quadratic {
 public:
  Quadratic(const PotentialPiece& piece, const std::array<Vec3, 4>& gradients) {
    linear_.fill(Vec3::Zero());
    square_.fill(Vec3::Zero());
    for (int k = 0; k < 6; ++k) {
      const int i = Tetrahedron::edges[k][0], j = Tetrahedron::edges[k][1];
      linear_[i] += piece.edges[k] * gradients[j];
      linear_[j] -= piece.edges[k] * gradients[i];
    }
    const auto& between = kCellTables<Tetrahedron>.edgeBetween;
    for (int f = 0; f < 4; ++f) {
      const auto& t = Tetrahedron::facets[f];
      for (int k = 0; k < 3; ++k) {
        const int x = t[k], y = t[(k + 1) % 3], z = t[(k + 2) % 3];
        square_[between[x][y]] += piece.facets[f][k] * gradients[z];
        square_[between[x][z]] -= piece.facets[f][k] * gradients[y];
      }
    }
  }

  /// Component `axis` where the barycentric coordinates are at + s slope, as a polynomial in s.
  std::array<double, 3> along(int axis, const double* at, const double* slope) const {
    std::array<double, 3> p{};
    for (int i = 0; i < 4; ++i) {
      p[0] += at[i] * linear_[i][axis];
      p[1] += slope[i] * linear_[i][axis];
    }
    for (int k = 0; k < 6; ++k) {
      const int i = Tetrahedron::edges[k][0], j = Tetrahedron::edges[k][1];
      const double w = square_[k][axis];
      p[0] += w * at[i] * at[j];
      p[1] += w * (at[i] * slope[j] + slope[i] * at[j]);
      p[2] += w * slope[i] * slope[j];
    }
    return p;
  }

 private:
  std::array<Vec3, 4> linear_;
  std::array<Vec3, 6> square_;
};

EdgeCirculations::EdgeCirculations(int corners) : corners_(corners) {
  for (auto& edges : edges_) edges.resize(static_cast<std::size_t>(corners) * corners * corners);
  used_ = true;
  clear();
}

void EdgeCirculations::clear() {
  if (!used_) return;
  for (auto& edges : edges_) edges.assign(edges.size(), Edge{0, 0});
  used_ = false;
}

bool EdgeCirculations::meets(const Box& box) const {
  for (int k = 0; k < 3; ++k) {
    if (!(box.max[k] >= 0 && box.min[k] <= corners_ - 1)) return false;
  }
  return true;
}

void EdgeCirculations::add(const PotentialPiece& piece) {
  Box box;
  for (const Vec3& p : piece.points) box.extend(p);
  if (!meets(box)) return;
  const Barycentric lambda(piece.points);
  if (!lambda.finite()) return;
  const Quadratic potential(piece, lambda.gradients);
  int from[3], to[3];  // corners in the box
  for (int k = 0; k < 3; ++k) {
    from[k] = static_cast<int>(std::ceil(std::max(box.min[k], 0.0)));
    to[k] = static_cast<int>(std::floor(std::min(box.max[k], corners_ - 1.0)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    double slope[4];
    for (int i = 0; i < 4; ++i) slope[i] = lambda.gradients[i][axis];
    for (int a = from[u]; a <= to[u]; ++a) {
      for (int b = from[v]; b <= to[v]; ++b) {
        Vec3 start;
        start[axis] = 0;
        start[u] = a;
        start[v] = b;
        double at[4], first = 0, last = corners_ - 1;
        for (int i = 0; i < 4; ++i) {
          at[i] = lambda.gradients[i].dot(start - lambda.origin) + (i == 0 ? 1 : 0);
          if (slope[i] > 0) {
            first = std::max(first, -at[i] / slope[i]);
          } else if (slope[i] < 0) {
            last = std::min(last, -at[i] / slope[i]);
          } else if (at[i] < 0) {
            last = -1;
          }
        }
        if (!(first < last)) continue;
        std::array<int, 3> corner;
        corner[u] = a;
        corner[v] = b;
        addLine(axis, corner, first, last, piece.sign, potential.along(axis, at, slope));
      }
    }
  }
}

/// Adds a polynomial's integral between two places on a line to the edges there.
void EdgeCirculations::addLine(int axis, std::array<int, 3> at, double from, double to, double sign,
                               const std::array<double, 3>& p) {
  used_ = true;
  for (int k = static_cast<int>(from); k < to; ++k) {
    const double low = std::max(from, static_cast<double>(k));
    const double high = std::min(to, static_cast<double>(k + 1));
    const double middle = (low + high) / 2, length = high - low;
    at[axis] = k;
    Edge& edge = edges_[axis][index(at)];
    edge.sum +=
        sign * length * (p[0] + p[1] * middle + p[2] * (middle * middle + length * length / 12));
    edge.length += sign * length;
  }
}

}  // namespace octet
