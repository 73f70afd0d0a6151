// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "../refine/refiner.h"
#include "fit_report.h"
#include "guides.h"

namespace octet {

struct FitDomain;
class FittedField;

/// What a fitted field is made of, and so what holds for it exactly.
enum class FitKind : std::uint8_t {
  DivergenceFree,  ///< a 2-form v = dA of a vector potential
  CurlFree,        ///< a 1-form v = df of a potential
  Free,            ///< a 2-form, neither
};

struct FitOptions {
  FitKind kind = FitKind::DivergenceFree;
  /// No flux through boundary facets without `flux`. Exact for 2-forms; a curl-free field only
  /// comes near it, and its report says how near.
  bool closedWalls = true;
  /// Boundary facets of the control mesh that the field may pass all the same; for 2-forms.
  std::vector<Index> openFacets;
  /// Outward flux through boundary facets of the control mesh, by facet; for 2-forms.
  std::map<Index, double> flux;
  /// Details smaller than this, as a share of the domain's size (the cube root of its volume), are
  /// smoothed away (smoothness.h); >= 0. With 0 guides alone decide, and have to.
  double smoothness = 0.01;
  int levels = 2;      ///< at which the limit field is compared with guides; at least as baked
  double spacing = 0;  ///< of samples along curves, world units; 0: a quarter of the mean edge
  double zeta = kDefaultZeta;
};

/// Coefficients on the control mesh.
struct FitResult {
  std::optional<Cochain<2>> flux;             ///< the field, as a 2-form
  std::optional<Cochain<1>> circulation;      ///< the field of a curl-free fit, as a 1-form
  std::optional<Cochain<1>> vectorPotential;  ///< A with flux = dA
  std::optional<Cochain<0>> potential;        ///< f with circulation = df
  /// How the form has to be refined for what is said here to hold: `bake --boundary`. Walls also
  /// where some facets have a given flux, which `auto` would take for open.
  BoundaryMode mode = BoundaryMode::Walls;
  FitReport report;
};

/// @brief Finds the smooth field that follows guides best: least squares for the control
/// coefficients, by their exact influence on the limit field (influence.h), plus a smoothness
/// energy (smoothness.h), subject to exact constraints (wall_potential.h).
///
/// Made once per cage and options, solved for any number of sets of guides, as they are moved
/// about. Const members are thread safe.
class Fit {
 public:
  /// @throws InputError for options that cannot be: a facet that is not on the boundary, given
  /// fluxes that do not add up, a negative smoothness. Cancelled
  Fit(const ControlMesh& mesh, const FitOptions& options = {}, const Context& context = {});
  ~Fit();
  Fit(Fit&&) noexcept;

  /// @throws InputError (file and place) for guides outside the domain or malformed, and when they
  /// do not determine the field; MemoryError; Cancelled.
  FitResult solve(const Guides& guides, const Context& context = {}) const;

 private:
  std::unique_ptr<const FitDomain> domain_;
  std::unique_ptr<const FittedField> field_;
};

}  // namespace octet
