// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <octet/core/hodge/potential.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/topology/control_mesh.h>

namespace octet {

/// What a 2-form's velocity can be baked from.
struct VelocityPlan {
  std::optional<VectorPotential> potential;  ///< on the control mesh; none: only samples remain
  std::string note;                          ///< why there is none, or what it cannot do
};

/// A form made closed, and by how much it was changed.
template <int K>
struct ClosedForm {
  Cochain<K> form;
  std::string note;  ///< empty when it was closed already
};

/// @brief Decides how forms of one control mesh are baked conservatively, and says why where they
/// cannot be. Factors are kept between frames. Thread safe.
class VelocityPlanner {
 public:
  /// The mesh must outlive it.
  explicit VelocityPlanner(const ControlMesh& mesh);
  ~VelocityPlanner();

  /// @param given  a potential of `velocity` that the user gave, or null. It is used as it is
  /// unless
  ///               walls are closed and it does not vanish along them.
  VelocityPlan plan(const Cochain<2>& velocity, const Cochain<1>* given) const;

  /// The closed form nearest to `form`; coefficients that are 0 on the boundary stay 0.
  template <int K>
  ClosedForm<K> closest(const Cochain<K>& form) const;

  /// By how much and where a form is not closed; empty when it is.
  template <int K>
  std::string describeOpenness(const Cochain<K>& form) const;

 private:
  struct Solvers;
  const ControlMesh& mesh_;
  std::unique_ptr<Solvers> solvers_;
};

}  // namespace octet
