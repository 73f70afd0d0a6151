// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "../forms/coboundary.h"
#include "../hodge/coboundary_matrix.h"
#include "fitted_field.h"
#include "smoothness.h"
#include "wall_potential.h"

namespace octet {
namespace {

using Matrix = Eigen::SparseMatrix<double>;

/// A fitted 2-form. Fluxes that are given, as those through walls, are no unknowns.
class FluxFit final : public FittedField {
 public:
  FluxFit(const FitDomain& domain, const Context& context)
      : domain_(domain), flux_(givenFlux()), influence_(makeInfluence(context)) {
    if (divergenceFree()) {
      takePotentials();
    } else {
      takeFluxes();
    }
    context.poll();
    if (domain.length > 0) {
      space_.setEnergy(smoothnessEnergy<2>(domain.complex(), domain.mesh.positions(), domain.length,
                                           /*curl=*/true, /*divergence=*/!divergenceFree()));
      space_.hasSilentUnknowns = divergenceFree();
    }
  }

  InfluenceRows at(const std::vector<Vec3>& points, const Context& context) const override {
    return influence_.at(points, context);
  }

  void addEquations(LeastSquares*) const override {}

  void store(const Eigen::VectorXd& x, const Eigen::VectorXd& coefficients,
             FitResult* result) const override {
    Cochain<2> flux(toArray(coefficients));
    const double largest = maxNorm(flux.values());
    double wall = 0;
    for (Index f = 0; f < flux.size(); ++f) {
      // Sums that are a wall's 0 or a given flux up to rounding: exactly that.
      if (!flux_[f]) continue;
      wall = std::max(wall, std::abs(flux[f] - *flux_[f]));
      flux[f] = *flux_[f];
    }
    FitReport& report = result->report;
    report.wallFlux = largest > 0 ? wall / largest : 0;
    report.divergence = largest > 0 ? maxNorm(d(domain_.complex(), flux).values()) / largest : 0;
    if (divergenceFree()) {
      result->vectorPotential = Cochain<1>(toArray(potential_.basis * x + potential_.particular));
    }
    result->flux = std::move(flux);
  }

  std::string remark() const override {
    if (mode_ != BoundaryMode::Walls || domain_.options.flux.empty()) return "";
    return "bake with --boundary walls: the walls are closed beside facets with a given flux";
  }

 private:
  bool divergenceFree() const { return domain_.options.kind == FitKind::DivergenceFree; }

  void checkBoundaryFacet(const char* what, Index f) const {
    const Complex& c = domain_.complex();
    if (f < 0 || f >= c.facetCount() || !c.facetOnBoundary(f)) {
      throw InputError(what, "facet " + std::to_string(f) + " is not on the boundary");
    }
  }

  /// Flux along the stored orientation of facets that have a given one.
  GivenFlux givenFlux() const {
    const Complex& c = domain_.complex();
    GivenFlux result(static_cast<std::size_t>(c.facetCount()));
    for (Index f = 0; domain_.options.closedWalls && f < c.facetCount(); ++f) {
      if (c.facetOnBoundary(f)) result[f] = 0;
    }
    for (const Index f : domain_.options.openFacets) {
      checkBoundaryFacet("open facets", f);
      result[f].reset();
    }
    for (const auto& [f, outward] : domain_.options.flux) {
      checkBoundaryFacet("given flux", f);
      if (!std::isfinite(outward)) throw InputError("given flux", "is not a finite number");
      // The stored facet points out of the first of its cells.
      result[f] = c.facetCells[f][0].exists() ? outward : -outward;
    }
    return result;
  }

  /// Also finds the boundary mode: walls, as soon as some facet is one.
  Influence<2> makeInfluence(const Context& context) {
    std::vector<std::uint8_t> zero;
    for (const auto& given : flux_) zero.push_back(given && *given == 0);
    const bool walls = std::find(zero.begin(), zero.end(), 1) != zero.end();
    mode_ = walls ? BoundaryMode::Walls : BoundaryMode::Open;
    return Influence<2>(domain_.refiner, domain_.limit, mode_, zero, context);
  }

  /// Unknowns of a free field: the fluxes that are not given.
  void takeFluxes() {
    const Index count = domain_.complex().facetCount();
    std::vector<Eigen::Triplet<double>> entries;
    Index unknowns = 0;
    Eigen::VectorXd particular = Eigen::VectorXd::Zero(count);
    for (Index f = 0; f < count; ++f) {
      if (flux_[f]) {
        particular[f] = *flux_[f];
      } else {
        entries.emplace_back(f, unknowns++, 1.0);
      }
    }
    FitSpace::RowMatrix basis(count, unknowns);
    basis.setFromTriplets(entries.begin(), entries.end());
    space_.setCoefficients(std::move(basis), std::move(particular));
  }

  /// Unknowns of a divergence-free field: those of its vector potential.
  void takePotentials() {
    const Complex& c = domain_.complex();
    const Matrix d1 = coboundaryMatrix<1>(c);
    potential_ = makeWallPotential(c, flux_);
    space_.setCoefficients(FitSpace::RowMatrix(d1 * potential_.basis), d1 * potential_.particular);
    space_.gauge = Matrix(potential_.basis.transpose()) *
                   Matrix(gaugeEnergy(c, domain_.mesh.positions(), potential_.gaugeVertices) *
                          potential_.basis);
  }

  const FitDomain& domain_;
  GivenFlux flux_;
  Influence<2> influence_;
  WallPotential potential_;  // of divergence-free fields
};

}  // namespace

std::unique_ptr<const FittedField> makeFluxFit(const FitDomain& domain, const Context& context) {
  return std::make_unique<FluxFit>(domain, context);
}

}  // namespace octet
