// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../refine/refiner.h"

namespace octet {

/// @brief One level of the projection-scaling method (thesis 5.3): what replaces the star rules at
/// simplices that touch the boundary. See ThesisMethod for the rule.
class LayerProjection {
 public:
  /// @param refiner    with star rows and without patch test
  /// @param level      the coarse level; `positions` its vertices as this method places them
  LayerProjection(const Refiner& refiner, int level, const Array<Vec3>& positions);

  /// Positions of the fine level.
  const Array<Vec3>& finePositions() const { return fineX_; }

  /// Adds the scaling to a function refined by star rows.
  void correct(const Cochain<0>& coarse, Cochain<0>* fine) const;
  /// Replaces the coefficients that touch the boundary; K = 1 or 2.
  template <int K>
  void replace(const Cochain<K>& coarse, Cochain<K>* fine) const;

 private:
  static constexpr int kMonomials = 9;  // x y z xx yy zz xy yz zx
  using Polynomial = Eigen::Matrix<double, kMonomials, 1>;

  /// The coarse layer at a boundary vertex and what it fits.
  struct Layer {
    Index vertex;
    std::vector<Index> vertices, edges, facets;
    double size;
    Eigen::Matrix<double, 3, Eigen::Dynamic> gradient;  // of a function, from values at vertices
  };

  void findLayers();
  void placeVertices();
  Layer makeLayer(Index vertex) const;
  /// Boundary rows of the coarse level that a fine boundary vertex belongs to: its own, or those at
  /// the ends of the edge that it halves.
  std::vector<Index> layersAt(Index fineVertex) const;
  Eigen::Matrix3d alongWall(Index fineVertex) const;
  /// Local monomials at a vertex, from refined global ones.
  Polynomial local(const Array<Polynomial>& monomials, const Layer& layer, Index vertex) const;
  template <int K>
  Eigen::VectorXd fit(const Layer& layer, const Cochain<K>& form) const;
  template <int K>
  Eigen::RowVectorXd basis(const std::array<Polynomial, K + 1>& corners) const;

  const Refiner& refiner_;
  const Complex &c_, &f_;
  const Boundary& boundary_;
  int level_;
  Array<Vec3> x_, fineX_;
  Vec3 origin_;
  std::vector<Layer> layers_;
  Array<Vec3> shift_;  // per fine vertex: what scaling adds to its position
  Array<Polynomial> coarseMonomials_, fineMonomials_;  // about origin_
};

}  // namespace octet
