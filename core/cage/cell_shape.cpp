// SPDX-License-Identifier: Apache-2.0
#include "cell_shape.h"

#include <cmath>

namespace octet {
namespace {

using Mat3 = Eigen::Matrix3d;

/// Adds a corner spanned by the columns of `d` out of regular `winv`^-1 to the shape; returns the
/// derivative of its distortion by d when `derive`.
Mat3 addCorner(const Mat3& d, const Mat3& winv, bool derive, CellShape* shape) {
  const double volume6 = d.determinant();
  shape->minVolume6 = std::min(shape->minVolume6, volume6);
  const Mat3 j = d * winv;
  const double det = j.determinant();
  if (!(det > 0)) {
    shape->distortion = HUGE_VAL;
    return Mat3::Zero();
  }
  const double scale = 1 / (3 * std::cbrt(det * det));
  const double f = j.squaredNorm() * scale;
  shape->distortion += f * f;
  if (!derive) return Mat3::Zero();
  // The cofactor matrix is det J^-T.
  Mat3 cofactor;
  cofactor.col(0) = j.col(1).cross(j.col(2));
  cofactor.col(1) = j.col(2).cross(j.col(0));
  cofactor.col(2) = j.col(0).cross(j.col(1));
  const Mat3 byJ = 2 * scale * j - (2 * f / (3 * det)) * cofactor;
  return 2 * f * byJ * winv.transpose();
}

/// Inverse of the edges of a regular tetrahedron at its first vertex, as columns.
Mat3 regularTetInverse() {
  Mat3 w;
  w << 1, 0.5, 0.5, 0, std::sqrt(3.0) / 2, std::sqrt(3.0) / 6, 0, 0, std::sqrt(2.0 / 3);
  return w.inverse();
}

}  // namespace

CellShape measureShape(const Complex& complex, const Array<Vec3>& positions, Index cell,
                       int vertex) {
  static const Mat3 tetInverse = regularTetInverse();
  CellShape shape;
  const double sign = complex.cellSigns[cell];
  Mat3 d;
  if (complex.isTet(cell)) {
    const auto& v = complex.tets[cell];
    for (int k = 0; k < 3; ++k) d.col(k) = positions[v[k + 1]] - positions[v[0]];
    if (sign < 0) d.col(0).swap(d.col(1));
    const Mat3 by = addCorner(d, tetInverse, vertex >= 0, &shape);
    if (vertex == 0) shape.gradient = -by.rowwise().sum();
    if (vertex > 0) {
      const int column = sign < 0 && vertex < 3 ? 2 - vertex : vertex - 1;
      shape.gradient = by.col(column);
    }
    return shape;
  }
  Vec3 p[6], centroid = Vec3::Zero();
  for (int i = 0; i < 6; ++i) {
    p[i] = positions[complex.cellVertex(cell, i)];
    centroid += p[i] / 6;
  }
  for (const auto& facet : Octahedron::facets) {
    int at[3] = {facet[0], facet[1], facet[2]};
    if (sign < 0) std::swap(at[0], at[1]);
    for (int k = 0; k < 3; ++k) d.col(k) = p[at[k]] - centroid;
    const Mat3 by = addCorner(d, Mat3::Identity(), vertex >= 0, &shape);
    if (vertex < 0) continue;
    shape.gradient -= by.rowwise().sum() / 6;
    for (int k = 0; k < 3; ++k) {
      if (at[k] == vertex) shape.gradient += by.col(k);
    }
  }
  return shape;
}

}  // namespace octet
