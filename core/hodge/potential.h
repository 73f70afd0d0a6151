// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "../base/context.h"
#include "../forms/cochain.h"

namespace octet {

/// How far a form is from closed: the largest |d w| of a simplex, and which.
struct Openness {
  double largest = 0;   ///< of |d w|
  double relative = 0;  ///< the same over the form's largest coefficient
  Index at = kNone;     ///< facet (of a 1-form) or cell (of a 2-form) where; kNone when w is 0
};
template <int K>
Openness openness(const Complex& complex, const Cochain<K>& form);

/// A form whose openness is below this, relative, counts as closed: what files with nine digits
/// leave over.
inline constexpr double kClosedTolerance = 1e-9;

/// One connected piece of the boundary surface (pieces that touch in an edge are one) and the net
/// flux out of the domain through it.
struct BoundaryPiece {
  Index facet;  ///< one of its facets
  double flux;
  double through;  ///< sum of the absolute fluxes
};
std::vector<BoundaryPiece> boundaryFluxes(const Complex& complex, const Cochain<2>& form);

/// A vector potential A of a closed 2-form, d A = w.
struct VectorPotential {
  Cochain<1> form;
  bool zeroOnBoundary;  ///< A is 0 on every boundary edge: then nothing crosses the walls
};

/// @brief Finds potentials of closed 2-forms on a control mesh (SCHEME.md section 9): of all A with
/// d A = w the one of least energy, which is the smooth one (it has no divergence).
///
/// First among those that vanish on the boundary, which exist when w does and no flow goes around
/// through handles of the domain; then among all. A potential exists unless the domain has voids
/// and w a net flux into one. Factors are made when first needed and kept, for animated forms.
/// Const members are thread safe. A direct solver: for control meshes.
class PotentialSolver {
 public:
  /// The arguments must outlive it.
  PotentialSolver(const Complex& complex, const Array<Vec3>& positions);
  ~PotentialSolver();
  PotentialSolver(PotentialSolver&&) noexcept;

  /// @return none when w has a part without potential: it is not closed, or see above.
  std::optional<VectorPotential> find(const Cochain<2>& form, const Context& context = {}) const;

 private:
  struct Systems;
  std::unique_ptr<Systems> systems_;
};

/// The potential f of a closed 1-form, d f = w, with mean 0 over the vertices of each connected
/// part. @return none when w has circulation around a facet, or around a hole of the domain.
std::optional<Cochain<0>> scalarPotential(const Complex& complex, const Cochain<1>& form);

}  // namespace octet
