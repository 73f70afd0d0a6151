// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "../field/field.h"

namespace octet {

/// The thesis' three answers to what subdivision does at the boundary (its chapter 5), beside the
/// walls and open rules of Refiner.
enum class BoundaryMethod : std::uint8_t {
  /// Interior rules with the cells there are; circulations and fluxes on the boundary become 0
  /// (5.2). Fields die out towards the boundary, positions shrink away from it.
  Simple,
  /// Simplices that touch the boundary take the derivatives of polynomials fitted to their coarse
  /// layer (5.3).
  Projection,
  /// A virtual layer around the mesh, carried along, makes the boundary interior (5.4, 5.5).
  Expansion,
};

/// @brief Refiner with one of the thesis' boundary methods: the same verbs.
///
/// What each keeps, on any mesh: see the table that samples/thesis/boundary makes. In short, with
/// `exactly` for to rounding:
/// - Simple: degree 0 refines exactly linear functions of position, forms lose their boundary; d
///   does not commute there. In the interior it is the scheme without its patch test.
/// - Projection: constants exactly. Inside, constant fluxes are exact by the patch test
///   (inner_patch_test.h). At the boundary a fit is made on the cells around a boundary vertex,
///   constants first, then what is left by d of quadratic potentials (circulations) or d(linear) ^
///   d(quadratic) (fluxes), if the layer has twice as many coefficients. Potentials are subdivided,
///   as numbers at vertices, by the rule of degree 0; a simplex takes the mean over its boundary
///   vertices. Scaling: a boundary vertex does not move along the normals of its facets, and
///   potentials change along by their own slope. d does not commute at the boundary: what is not d
///   of a quadratic there is lost.
/// - Expansion: constants exactly, and d commutes with all degrees, so that what is curl-free or
///   incompressible stays so, unless `commutes()` denies it (extension.h, virtual_layer.h). On a
///   lattice block everything is the scheme on the infinite lattice. A constant density is kept on
///   lattice blocks; elsewhere it changes next to the boundary.
///
/// Const members are thread safe.
class MethodRefiner {
 public:
  /// `options.patchTest` and `options.boundaryRows` are the method's own and not looked at.
  /// @throws InputError as Refiner, and for a mesh that cannot be expanded
  MethodRefiner(const ControlMesh& mesh, BoundaryMethod method, const RefinerOptions& options = {});
  ~MethodRefiner();
  MethodRefiner(MethodRefiner&&) noexcept;
  MethodRefiner& operator=(MethodRefiner&&) noexcept;

  int levels() const;
  BoundaryMethod method() const;
  /// Whether refining commutes with d on the whole mesh: with Expansion, unless the mesh has a gap
  /// that its virtual layer fills; with the others never.
  bool commutes() const;
  /// Topology of a level, the same as Refiner's.
  const Complex& complex(int level) const;
  std::shared_ptr<const Complex> sharedComplex(int level) const;
  /// Vertex positions of a level as the method refines them, world units.
  const Array<Vec3>& positions(int level) const;

  /// Coefficients on level `level` from those on the control mesh.
  template <int K>
  Cochain<K> refine(const Cochain<K>& form, int level) const;
  template <int K>
  Cochain<K> refine(const Cochain<K>& form) const {
    return refine(form, levels());
  }

  /// Positions that fields are given on: limits for Expansion, else the finest level's own.
  const Array<Vec3>& fieldPositions() const;
  /// Has it limits? Only Expansion.
  bool hasLimits() const;
  /// Limit values and vectors of a control form at the finest vertices, K = 1 or 2, which belong to
  /// fieldPositions(). @throws std::logic_error where there are none
  Array<double> limitValues(const Cochain<0>& form) const;
  template <int K>
  Array<Vec3> limitVectors(const Cochain<K>& form) const;
  /// The field of a control form. Simple and Projection are rebuilt by Whitney forms, as in the
  /// thesis, whatever is asked for.
  template <int K>
  Field<kComponents<K>> field(const Cochain<K>& form,
                              Reconstruction reconstruction = Reconstruction::Limit) const;

 private:
  class Rules;
  class ShrinkingRules;
  class ExpandingRules;
  std::unique_ptr<Rules> rules_;
};

}  // namespace octet
