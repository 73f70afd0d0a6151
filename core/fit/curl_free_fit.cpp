// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "../hodge/coboundary_matrix.h"
#include "fitted_field.h"
#include "smoothness.h"

namespace octet {
namespace {

/// Weight of no flow through the walls, against 1 for all guides.
constexpr double kWallWeight = 10;

/// A fitted 1-form df. Unknowns: the potential f at control vertices.
class CurlFreeFit final : public FittedField {
 public:
  CurlFreeFit(const FitDomain& domain, const Context& context)
      : domain_(domain),
        influence_(domain.refiner, domain.limit, mode_,
                   std::vector<std::uint8_t>(domain.complex().edges.size(), 0), context) {
    const Complex& c = domain.complex();
    space_.setCoefficients(coboundaryMatrix<0>(c), Eigen::VectorXd::Zero(c.edgeCount()));
    if (domain.length > 0) {
      space_.setEnergy(smoothnessEnergy<1>(c, domain.mesh.positions(), domain.length,
                                           /*curl=*/false, /*divergence=*/true));
      space_.hasSilentUnknowns = true;
    }
    if (domain.options.closedWalls) prepareWalls(context);
  }

  InfluenceRows at(const std::vector<Vec3>& points, const Context& context) const override {
    return influence_.at(points, context);
  }

  void addEquations(LeastSquares* problem) const override {
    double area = 0;
    for (const Vec3& a : wallAreas_) area += a.norm();
    for (std::size_t k = 0; k < normalRows_.size(); ++k) {
      problem->rows.push_back(normalRows_[k]);
      problem->weights.push_back(kWallWeight * wallAreas_[k].norm() / area);
      problem->rights.push_back(0);
    }
  }

  void store(const Eigen::VectorXd& x, const Eigen::VectorXd& coefficients,
             FitResult* result) const override {
    result->circulation = Cochain<1>(toArray(coefficients));
    result->potential = Cochain<0>(toArray(x));
    double through = 0, all = 0;
    for (std::size_t k = 0; k < wallAreas_.size(); ++k) {
      const double area = wallAreas_[k].norm();
      through += area * std::pow(normalRows_[k].apply(x.data()), 2);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        all += area * std::pow(vectorRows_[3 * k + axis].apply(coefficients.data()), 2);
      }
    }
    result->report.wallFlux = all > 0 ? std::sqrt(through / all) : 0;
  }

  std::string remark() const override {
    if (!domain_.options.closedWalls) return "";
    return "a curl-free field meets closed walls only nearly: see the flow through them";
  }

 private:
  /// Takes a point on every wall facet, at which the field should not pass.
  void prepareWalls(const Context& context) {
    const Complex& c = domain_.refiner.finest();
    const Array<Vec3>& x = domain_.limit.positions();
    std::vector<Vec3> points;
    for (const Index f : domain_.refiner.boundary(domain_.refiner.levels()).facets) {
      const auto v = c.facetVertices(f);
      const Vec3 area = (x[v[1]] - x[v[0]]).cross(x[v[2]] - x[v[0]]) / 2;
      if (!(area.norm() > 0)) continue;
      points.push_back((x[v[0]] + x[v[1]] + x[v[2]]) / 3);
      wallAreas_.push_back(area);
    }
    vectorRows_ = influence_.at(points, context).rows;
    std::vector<SparseRow> normals;
    RowSum sum(domain_.complex().edgeCount());
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Vec3 normal = wallAreas_[k].normalized();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const SparseRow& row = vectorRows_[3 * k + axis];
        for (std::size_t j = 0; j < row.size(); ++j) {
          sum.add(row.index[j], normal[static_cast<Index>(axis)] * row.weight[j]);
        }
      }
      normals.push_back(sum.take());
    }
    normalRows_ = throughBasis(normals, space_, context);
  }

  const FitDomain& domain_;
  Influence<1> influence_;
  std::vector<Vec3> wallAreas_;        // area vectors of the finest wall facets
  std::vector<SparseRow> normalRows_;  // through each of them, over unknowns
  std::vector<SparseRow> vectorRows_;  // the vectors there, over coefficients
};

}  // namespace

std::unique_ptr<const FittedField> makeCurlFreeFit(const FitDomain& domain,
                                                   const Context& context) {
  return std::make_unique<CurlFreeFit>(domain, context);
}

}  // namespace octet
