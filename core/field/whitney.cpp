// SPDX-License-Identifier: Apache-2.0
#include "whitney.h"

#include <Eigen/Dense>

#include "../rules/local_linear.h"

namespace octet {
namespace {

/// Octahedra this many splits down are filled with a constant: 2^-20 of the cell's size.
constexpr int kDeepest = 20;

/// Coefficients of a form on one cell: vertices; edges, lower to higher local vertex; outward
/// facets; or the cell's mass.
template <int K, typename Shape>
inline constexpr int kLocalCount = K == 0   ? Shape::kVertices
                                   : K == 1 ? Shape::kEdges
                                   : K == 2 ? Shape::kFacets
                                            : 1;
template <int K, typename Shape>
using LocalForm = std::array<double, kLocalCount<K, Shape>>;

template <int K, typename Shape>
LocalForm<K, Shape> localForm(const Complex& c, Index cell, const Cochain<K>& form) {
  LocalForm<K, Shape> local;
  for (int k = 0; k < kLocalCount<K, Shape>; ++k) {
    if constexpr (K == 0) local[k] = form[c.cellVertex(cell, k)];
    if constexpr (K == 1)
      local[k] = form.at(c.cellEdge(cell, Shape::edges[k][0], Shape::edges[k][1]));
    if constexpr (K == 2) local[k] = form.at(c.cellFacet(cell, k));
    if constexpr (K == 3) local[k] = form[cell];
  }
  return local;
}

template <typename Shape>
double volume6(const std::array<Vec3, Shape::kVertices>& p) {
  Vec3 centroid = Vec3::Zero();
  for (const Vec3& x : p) centroid += x / static_cast<double>(Shape::kVertices);
  double sum = 0;
  for (const auto& f : Shape::facets) {
    sum += (p[f[0]] - centroid).dot((p[f[1]] - centroid).cross(p[f[2]] - centroid));
  }
  return sum;
}

/// The Whitney form in a tetrahedron (thesis 3.2.2), by its values at the corners.
/// @param p      corners in the world
/// @param shape  the same up to a translation, with all digits of their differences
template <int K>
Piece<kComponents<K>> whitneyPiece(const std::array<Vec3, 4>& p, const std::array<Vec3, 4>& shape,
                                   const LocalForm<K, Tetrahedron>& w) {
  Piece<kComponents<K>> piece;
  piece.points = p;
  const Barycentric lambda(shape);
  for (int a = 0; a < 4; ++a) {
    auto& value = piece.values[a];
    value.setZero();
    if constexpr (K == 0) value[0] = w[a];
    if constexpr (K == 1) {
      for (int b = 0; b < 4; ++b) {
        if (b == a) continue;
        const int e = kCellTables<Tetrahedron>.edgeBetween[a][b];
        value += (a < b ? w[e] : -w[e]) * lambda.gradients[b];
      }
    }
    if constexpr (K == 2) {
      for (int f = 0; f < 4; ++f) {
        const auto& t = Tetrahedron::facets[f];
        for (int s = 0; s < 3; ++s) {
          if (t[s] != a) continue;
          value +=
              2 * w[f] * lambda.gradients[t[(s + 1) % 3]].cross(lambda.gradients[t[(s + 2) % 3]]);
        }
      }
    }
    if constexpr (K == 3) value[0] = w[0] / std::abs(volume6<Tetrahedron>(shape) / 6);
  }
  return piece;
}

/// The constant nearest to a form on an octahedron.
template <int K>
typename Piece<kComponents<K>>::Value nearestConstant(const std::array<Vec3, 6>& p,
                                                      const LocalForm<K, Octahedron>& w) {
  typename Piece<kComponents<K>>::Value value;
  if constexpr (K == 0) {
    value.setZero();
    for (const double x : w) value[0] += x / 6;
  } else if constexpr (K == 3) {
    value[0] = w[0] / std::abs(volume6<Octahedron>(p) / 6);
  } else {
    Eigen::Matrix<double, kLocalCount<K, Octahedron>, 3> measures;
    Eigen::Matrix<double, kLocalCount<K, Octahedron>, 1> right;
    for (int k = 0; k < kLocalCount<K, Octahedron>; ++k) {
      if constexpr (K == 1) {
        measures.row(k) = p[Octahedron::edges[k][1]] - p[Octahedron::edges[k][0]];
      } else {
        const auto& t = Octahedron::facets[k];
        measures.row(k) = (p[t[1]] - p[t[0]]).cross(p[t[2]] - p[t[0]]) / 2;
      }
      right[k] = w[k];
    }
    value = (measures.transpose() * measures).ldlt().solve(measures.transpose() * right);
  }
  return value;
}

/// Linear subdivision of a form on an octahedron, as matrices to its children's coefficients.
template <int K>
class OctahedronSplit {
 public:
  explicit OctahedronSplit(const LinearRules& rules) {
    const auto& split = SplitTables<Octahedron>::get();
    for (int k = 0; k < 8; ++k) fill<Tetrahedron>(rules, split.tets[k], &tets_[k], 1.0 / 32);
    for (int k = 0; k < 6; ++k) fill<Octahedron>(rules, split.octs[k], &octs_[k], 1.0 / 8);
  }

  LocalForm<K, Tetrahedron> tet(int k, const LocalForm<K, Octahedron>& w) const {
    return multiply<Tetrahedron>(tets_[k], w);
  }
  LocalForm<K, Octahedron> oct(int k, const LocalForm<K, Octahedron>& w) const {
    return multiply<Octahedron>(octs_[k], w);
  }

 private:
  template <typename Shape>
  using Matrix = std::array<LocalForm<K, Octahedron>, kLocalCount<K, Shape>>;

  template <typename Shape>
  static void fill(const LinearRules& rules, const std::uint8_t* child, Matrix<Shape>* matrix,
                   double massShare) {
    const LocalLinear<Octahedron> linear(rules);
    for (int k = 0; k < kLocalCount<K, Shape>; ++k) {
      auto& row = (*matrix)[k];
      row.fill(0);
      if constexpr (K == 0) {
        const int label = child[k];
        if (label == kCentreLabel) {
          row.fill(1.0 / 6);
        } else if (label < 6) {
          row[label] = 1;
        } else {
          for (const int i : Octahedron::edges[label - 6]) row[i] = 0.5;
        }
      } else if constexpr (K == 1) {
        row = linear.edge(child[Shape::edges[k][0]], child[Shape::edges[k][1]]);
      } else if constexpr (K == 2) {
        const auto& t = Shape::facets[k];
        row = linear.facet(child[t[0]], child[t[1]], child[t[2]]);
      } else {
        row[0] = massShare;
      }
    }
  }

  template <typename Shape>
  static LocalForm<K, Shape> multiply(const Matrix<Shape>& matrix,
                                      const LocalForm<K, Octahedron>& w) {
    LocalForm<K, Shape> result;
    for (std::size_t k = 0; k < result.size(); ++k) {
      result[k] = 0;
      for (std::size_t j = 0; j < w.size(); ++j) result[k] += matrix[k][j] * w[j];
    }
    return result;
  }

  std::array<Matrix<Tetrahedron>, 8> tets_;
  std::array<Matrix<Octahedron>, 6> octs_;
};

/// Linear pieces of an octahedron's Whitney form, by recursion into its child octahedra.
template <int K>
class OctahedronPieces {
 public:
  OctahedronPieces(const OctahedronSplit<K>& split, const typename Whitney<K>::Filter& wanted,
                   const typename Whitney<K>::Sink& sink)
      : split_(split), wanted_(wanted), sink_(sink) {}

  /// @param origin  of `shape`, the octahedron's vertices relative to it: differences of positions
  ///                in the world would lose a digit every three splits
  void visit(const Vec3& origin, const std::array<Vec3, 6>& shape,
             const LocalForm<K, Octahedron>& w, int depth) const {
    Box box;
    for (const Vec3& x : shape) box.extend(origin + x);
    if (!wanted_(box)) return;
    std::array<Vec3, kCentreLabel + 1> fine;
    fine[kCentreLabel].setZero();
    for (int i = 0; i < 6; ++i) {
      fine[i] = shape[i];
      fine[kCentreLabel] += shape[i] / 6;
    }
    for (int k = 0; k < 12; ++k) {
      fine[6 + k] = (shape[Octahedron::edges[k][0]] + shape[Octahedron::edges[k][1]]) / 2;
    }
    if (depth == kDeepest) return fill(origin, fine, nearestConstant<K>(shape, w));
    const auto& labels = SplitTables<Octahedron>::get();
    for (int k = 0; k < 8; ++k) {
      std::array<Vec3, 4> child, inWorld;
      Box childBox;
      for (int i = 0; i < 4; ++i) {
        child[i] = fine[labels.tets[k][i]] - fine[kCentreLabel];
        inWorld[i] = origin + fine[labels.tets[k][i]];
        childBox.extend(inWorld[i]);
      }
      if (wanted_(childBox)) sink_(whitneyPiece<K>(inWorld, child, split_.tet(k, w)));
    }
    for (int k = 0; k < 6; ++k) {
      std::array<Vec3, 6> child;
      for (int i = 0; i < 6; ++i) child[i] = fine[labels.octs[k][i]] - fine[k];
      visit(origin + fine[k], child, split_.oct(k, w), depth + 1);
    }
  }

 private:
  void fill(const Vec3& origin, const std::array<Vec3, kCentreLabel + 1>& fine,
            const typename Piece<Whitney<K>::C>::Value& value) const {
    Piece<Whitney<K>::C> piece;
    piece.values.fill(value);
    for (const auto& f : Octahedron::facets) {
      piece.points = {origin + fine[f[0]], origin + fine[f[1]], origin + fine[f[2]],
                      origin + fine[kCentreLabel]};
      sink_(piece);
    }
  }

  const OctahedronSplit<K>& split_;
  const typename Whitney<K>::Filter& wanted_;
  const typename Whitney<K>::Sink& sink_;
};

}  // namespace

template <int K>
struct Whitney<K>::Tables {
  explicit Tables(const LinearRules& rules) : split(rules) {}
  OctahedronSplit<K> split;
};

template <int K>
Whitney<K>::Whitney(std::shared_ptr<const Complex> complex, Array<Vec3> positions, Cochain<K> form,
                    double zeta)
    : PieceSource<C>(std::move(complex), std::move(positions)),
      form_(std::move(form)),
      tables_(std::make_shared<Tables>(LinearRules(zeta))) {}

template <int K>
void Whitney<K>::visitPieces(Index cell, const Filter& wanted, const Sink& sink) const {
  const Complex& c = this->complex();
  const Array<Vec3>& x = this->positions();
  if (c.isTet(cell)) {
    std::array<Vec3, 4> p;
    Box box;
    for (int i = 0; i < 4; ++i) {
      p[i] = x[c.tets[cell][i]];
      box.extend(p[i]);
    }
    if (wanted(box)) sink(whitneyPiece<K>(p, p, localForm<K, Tetrahedron>(c, cell, form_)));
    return;
  }
  const Vec3& origin = x[c.cellVertex(cell, 0)];
  std::array<Vec3, 6> shape;
  for (int i = 0; i < 6; ++i) shape[i] = x[c.cellVertex(cell, i)] - origin;
  OctahedronPieces<K>(tables_->split, wanted, sink)
      .visit(origin, shape, localForm<K, Octahedron>(c, cell, form_), 0);
}

template class Whitney<0>;
template class Whitney<1>;
template class Whitney<2>;
template class Whitney<3>;

}  // namespace octet
