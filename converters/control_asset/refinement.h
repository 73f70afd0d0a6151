// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <octet/core/field/field.h>
#include <octet/core/field/limit.h>

#include "refined_document.h"

namespace octet {

/// @brief A control mesh refined by the scheme or by one of the thesis' boundary methods, with the
/// same verbs for both. All take coefficients on the control mesh; a form's BoundaryMode does not
/// matter to the methods. Const members are thread safe.
class Refinement {
 public:
  /// @throws InputError as Refiner and MethodRefiner
  Refinement(const ControlMesh& mesh, BoundaryChoice boundary, const RefinerOptions& options);

  int levels() const;
  std::shared_ptr<const Complex> complex(int level) const;
  std::shared_ptr<const Complex> finest() const { return complex(levels()); }
  /// Vertex positions of a level, world units.
  const Array<Vec3>& positions(int level) const;
  /// Positions on the finest level that limit fields are given on.
  const Array<Vec3>& limitPositions() const;

  /// Are there limits? Simple and projection have none: their fields are Whitney forms.
  bool hasLimits() const;
  /// Does refining commute with d, so that a refined potential's derivative is the refined form?
  bool commutes() const;
  /// What the method does not keep on this mesh (methodNote); empty for the scheme.
  std::string note() const;

  template <int K>
  Cochain<K> refine(const Cochain<K>& control, BoundaryMode mode) const;
  /// Limit values at the finest vertices. @throws std::logic_error without limits; so does:
  Array<double> limitValues(const Cochain<0>& control, BoundaryMode mode) const;
  /// Limit vectors at the finest vertices, K = 1 or 2.
  template <int K>
  Array<Vec3> limitVectors(const Cochain<K>& control, BoundaryMode mode) const;
  template <int K>
  Field<kComponents<K>> field(const Cochain<K>& control, BoundaryMode mode,
                              Reconstruction reconstruction) const;

 private:
  // One or the other.
  std::unique_ptr<Refiner> refiner_;
  std::unique_ptr<Limit> limit_;
  std::unique_ptr<MethodRefiner> method_;
};

}  // namespace octet
