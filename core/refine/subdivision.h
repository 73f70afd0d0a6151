// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "../base/context.h"
#include "../forms/cochain.h"
#include "smoothing.h"

namespace octet {

/// @brief A control mesh that was subdivided by some rule, and what the rule makes of forms on it.
///
/// All verbs take coefficients on the control mesh, level 0. Rules differ in where they place
/// vertices and in what they do at the boundary; the topology of a level is the same for all.
/// SchemeSubdivision is the rule of SCHEME.md. Const members are thread safe.
class Subdivision {
 public:
  virtual ~Subdivision() = default;

  /// Number of subdivisions.
  virtual int levels() const = 0;
  /// Topology of a level; 0 is the control mesh, levels() the finest.
  virtual std::shared_ptr<const Complex> complex(int level) const = 0;
  std::shared_ptr<const Complex> finest() const { return complex(levels()); }
  /// Vertex positions of a level, world units.
  virtual const Array<Vec3>& positions(int level) const = 0;
  /// Free weight of the octahedron's linear rule.
  virtual double zeta() const = 0;

  /// @name What the rule keeps
  /// @{
  /// Name of a rule of its own for the boundary, to which a form's BoundaryMode does not matter;
  /// empty where it does.
  virtual std::string boundaryRule() const { return ""; }
  /// Does refining commute with d, so that a refined potential's derivative is the refined form?
  virtual bool commutes() const { return true; }
  /// Says what is not kept on this mesh, if anything.
  virtual std::string note() const { return ""; }
  /// @}

  /// @name Coefficients on the finest level from those on the control mesh
  /// @throws InputError for a form of another mesh
  /// @{
  virtual Cochain<0> refine(const Cochain<0>& control, BoundaryMode mode,
                            const Context& context = {}) const = 0;
  virtual Cochain<1> refine(const Cochain<1>& control, BoundaryMode mode,
                            const Context& context = {}) const = 0;
  virtual Cochain<2> refine(const Cochain<2>& control, BoundaryMode mode,
                            const Context& context = {}) const = 0;
  virtual Cochain<3> refine(const Cochain<3>& control, BoundaryMode mode,
                            const Context& context = {}) const = 0;
  /// @}

  /// @name Limits at the finest level's vertices (see class Limit)
  /// @throws std::logic_error where there are none
  /// @{
  virtual bool hasLimits() const { return true; }
  /// The positions that limits belong to, world units; where there are none the finest level's own.
  virtual const Array<Vec3>& limitPositions(const Context& context = {}) const = 0;
  virtual Array<double> limitValues(const Cochain<0>& control, BoundaryMode mode,
                                    const Context& context = {}) const = 0;
  virtual Array<Vec3> limitVectors(const Cochain<1>& control, BoundaryMode mode,
                                   const Context& context = {}) const = 0;
  virtual Array<Vec3> limitVectors(const Cochain<2>& control, BoundaryMode mode,
                                   const Context& context = {}) const = 0;
  virtual Array<double> limitDensities(const Cochain<3>& control, BoundaryMode mode,
                                       const Context& context = {}) const = 0;
  /// @}
};

}  // namespace octet
