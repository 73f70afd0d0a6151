// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "../topology/control_mesh.h"
#include "potential.h"
#include "projection.h"

namespace octet {

/// Tells by how much and where a form is not closed.
struct NotClosed {
  int degree = 0;         ///< of the form
  double largest = 0;     ///< of |d w|
  double relative = 0;    ///< the same over the form's largest coefficient
  std::string simplex{};  ///< name of the cell that it leaves, or of the facet that it runs around
  Vec3 centre = Vec3::Zero();  ///< of that simplex
};

/// A flow goes out of the domain through pieces of its boundary, as into a void: then it has no
/// vector potential.
struct LeavesVoid {
  struct NetFlux {
    double flux;
    Vec3 near;  ///< a vertex of the piece
  };
  std::vector<NetFlux> fluxes;  ///< those that are more than rounding; may be none
};

/// A flow goes around through a handle of the domain: walls are closed, but its potential does not
/// vanish along them.
struct AroundHandle {};

/// What a 2-form's velocity can be had from.
struct VelocityPlan {
  using Flaw = std::variant<NotClosed, LeavesVoid, AroundHandle>;

  std::optional<VectorPotential> potential;  ///< on the control mesh; none: only samples remain
  std::optional<Flaw> flaw;                  ///< why there is none, or what it cannot do
};

/// A form made closed, and by how much it was changed.
template <int K>
struct ClosedForm {
  Cochain<K> form;
  std::optional<NotClosed> was;  ///< none when it was closed already
  double changed = 0;            ///< norm of the change over the form's norm
};

/// @brief Finds what forms of one control mesh can be had from conservatively, and the reason where
/// they cannot. Factors are kept between frames. Thread safe.
class VelocityPlanner {
 public:
  /// The mesh must outlive it.
  explicit VelocityPlanner(const ControlMesh& mesh);
  ~VelocityPlanner();

  /// @param given  a potential of `velocity` that the user gave, or null. It is used as it is
  /// unless
  ///               walls are closed and it does not vanish along them.
  VelocityPlan plan(const Cochain<2>& velocity, const Cochain<1>* given,
                    const Context& context = {}) const;

  /// The closed form nearest to `form`; coefficients that are 0 on the boundary stay 0.
  template <int K>
  ClosedForm<K> closest(const Cochain<K>& form, const Context& context = {}) const;

  /// By how much and where a form is not closed; none when it is.
  template <int K>
  std::optional<NotClosed> whereOpen(const Cochain<K>& form) const;

 private:
  struct Solvers;
  const ControlMesh& mesh_;
  std::unique_ptr<Solvers> solvers_;
};

}  // namespace octet
