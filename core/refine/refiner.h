// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "../base/context.h"
#include "../forms/cochain.h"
#include "../topology/boundary.h"
#include "../topology/control_mesh.h"
#include "../topology/lattice_sites.h"
#include "boundary_mode.h"
#include "linear_refinement.h"

namespace octet {

struct CellKernels;
class ScratchPool;
class StepAdjoint;

struct RefinerOptions {
  int levels = 1;              ///< number of subdivisions, 0 to 12
  double zeta = kDefaultZeta;  ///< free weight of the octahedron's linear rule (LinearRules)
  bool smooth = true;          ///< false: linear (Whitney) subdivision only; positions stay put
  bool patchTest = true;       ///< false: without the correction for constant fluxes
  BoundaryRows boundaryRows = BoundaryRows::Smooth;  ///< Star needs patchTest = false
};

/// @brief Subdivides a control mesh and the forms on it (SCHEME.md sections 3 to 8).
///
/// The operators of each level are built once, from topology and control positions, and then
/// applied to any number of forms of degree 0 to 3: an animated asset pays for its topology once.
/// They commute with the exterior derivative, d S = S d, to rounding, on every mesh and in both
/// boundary modes. Memory is linear in the finest level. Const members are thread safe.
class Refiner {
 public:
  /// @throws InputError for levels out of range, more simplices than can be numbered, or options
  /// that exclude one another; MemoryError before a level that does not fit; Cancelled
  explicit Refiner(const ControlMesh& mesh, const RefinerOptions& options = {},
                   const Context& context = {});
  ~Refiner();
  Refiner(Refiner&&) noexcept;
  Refiner& operator=(Refiner&&) noexcept;

  int levels() const;
  /// Topology of a level; 0 is the control mesh, levels() the finest.
  const Complex& complex(int level) const;
  const Complex& finest() const { return complex(levels()); }
  std::shared_ptr<const Complex> sharedComplex(int level) const;
  /// Vertex positions of a level, world units.
  const Array<Vec3>& positions(int level) const;
  const Boundary& boundary(int level) const;
  const LatticeSites& sites(int level) const;
  double zeta() const { return options_.zeta; }
  /// Smooth subdivision, not just linear?
  bool smooth() const { return options_.smooth; }
  BoundaryRows boundaryRows() const { return options_.boundaryRows; }

  /// One step: coefficients on level `level` + 1 from those on `level`.
  template <int K>
  Cochain<K> step(int level, const Cochain<K>& form, BoundaryMode mode,
                  const Context& context = {}) const;
  /// Coefficients on the finest level from those on the control mesh.
  template <int K>
  Cochain<K> refine(Cochain<K> form, BoundaryMode mode, const Context& context = {}) const;

  /// One step by rows: how single coefficients on level `level` + 1 depend on level `level`.
  /// @throws InputError with BoundaryRows::Star
  StepAdjoint rows(int level, BoundaryMode mode) const;

 private:
  struct Level;
  RefinerOptions options_;
  LinearRefinement linear_;
  std::unique_ptr<CellKernels> kernels_;
  std::unique_ptr<ScratchPool> scratch_;
  std::vector<std::unique_ptr<Level>> levels_;  // refer to kernels and scratch
  MemoryReservation memory_;                    // what they take
};

/// The mode that keeps what the form says about its boundary: walls where all its boundary
/// coefficients are 0 and for degrees 0 and 3, which refine the same in both modes; else open.
template <int K>
BoundaryMode automaticMode(const Complex& control, const Cochain<K>& form);

}  // namespace octet
