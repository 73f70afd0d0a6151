// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "../refine/refiner.h"

namespace octet {

/// How the subdivision around a vertex is looked at.
struct LocalSubdivisionOptions {
  double zeta = kDefaultZeta;
  BoundaryMode mode = BoundaryMode::Walls;
  bool patchTest = true;  ///< with the correction that makes constant fluxes exact
  BoundaryRows boundaryRows = BoundaryRows::Smooth;  ///< not Star
  /// Let the star take the shape that subdivision brings it to, up to an affine map: what the
  /// eigenvalues describe is then the same at every finer level. false: its shape as it is.
  bool settle = true;
};

/// @brief The subdivision matrix of a vertex' 1-ring (thesis 1.1 and 4.3.1, SCHEME.md section 5).
///
/// A vertex persists under refinement and its fine star looks like its coarse one: the child that
/// keeps the corner of a cell has the cell's own local numbering, so simplices of the two stars are
/// identified place by place. The fine 1-ring depends on the coarse 1-ring only, at any vertex,
/// interior or on the boundary, so the matrix is square and its powers are what repeated
/// subdivision does there.
///
/// The star is cut out as a mesh of its own, with the lattice regions that its cells lie in, and
/// split once before the step: in a control mesh other irregular vertices beside this one have
/// their own rules' say in the first step, and in no later one.
class LocalSubdivision {
 public:
  /// @param vertex  of the refiner's level `level`
  /// @throws InputError for a vertex that does not exist, has no cells, or whose settled star folds
  ///         (at interior edges of more than 10 tetrahedra, unless it is symmetric: a saddle then
  ///         dies out more slowly than the direction along the edge)
  LocalSubdivision(const Refiner& refiner, int level, Index vertex,
                   const LocalSubdivisionOptions& options = {});
  ~LocalSubdivision();
  LocalSubdivision(LocalSubdivision&&) noexcept;

  /// The closed star; its simplices are the rows and columns, in stored orientation.
  const Complex& star() const { return *star_; }
  /// The vertex in the star.
  Index centre() const { return centre_; }
  /// Vertices of the star, as vertices of the level.
  const std::vector<Index>& vertices() const { return vertices_; }
  VertexType type() const { return type_; }
  /// Positions that the matrices were made with; the centre is at the origin once settled.
  const Array<Vec3>& positions() const { return positions_; }

  /// Row: fine simplex in the place of a coarse one; column: coarse simplex. K = 0, 1, 2.
  template <int K>
  Eigen::MatrixXd matrix() const;

  /// The three constant fields as K-forms on the star (K = 1: d x, K = 2: area vectors), one a
  /// column.
  template <int K>
  Eigen::MatrixXd constants() const;

 private:
  void cutOut(const Refiner& refiner, int level, Index vertex);
  void settle();

  class Generic;

  LocalSubdivisionOptions options_;
  ControlMeshInput input_;
  std::unique_ptr<Generic> generic_;
  std::shared_ptr<const Complex> star_;
  Index centre_ = kNone;
  VertexType type_ = VertexType::R;
  std::vector<Index> vertices_;
  Array<Vec3> positions_;
};

}  // namespace octet
