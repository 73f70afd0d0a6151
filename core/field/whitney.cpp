// SPDX-License-Identifier: Apache-2.0
#include "whitney.h"

#include <Eigen/Dense>

#include "whitney_piece.h"

namespace octet {
namespace {

/// Octahedra this many splits down are filled with a constant: 2^-20 of the cell's size.
constexpr int kDeepest = 20;

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
