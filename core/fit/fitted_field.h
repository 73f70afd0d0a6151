// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "fit.h"
#include "influence.h"
#include "least_squares.h"

namespace octet {

/// What every kind of field is fitted on: the cage, its refinement and the limit field's vertices.
struct FitDomain {
  /// @throws InputError for options that cannot be.
  FitDomain(const ControlMesh& mesh, const FitOptions& options, const Context& context);

  const Complex& complex() const { return *mesh.complex(); }

  FitOptions options;
  ControlMesh mesh;
  Refiner refiner;
  Limit limit;
  double edge;    ///< mean edge of the cage, world units
  double length;  ///< details smaller than this are smoothed away, world units; 0: none are
};

/// @brief The fields that a fit chooses from: control coefficients basis x + particular, x free,
/// and what x costs.
struct FitSpace {
  using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

  /// Sets basis and particular; nothing is charged yet.
  void setCoefficients(RowMatrix newBasis, Eigen::VectorXd newParticular);
  /// Charges a quadratic form on coefficients, the smoothness energy, and so on x.
  void setEnergy(const Eigen::SparseMatrix<double>& onCoefficients);

  RowMatrix basis;
  Eigen::VectorXd particular;
  Eigen::SparseMatrix<double> energy;  ///< x' energy x - 2 energyPull' x is the cost of bending
  Eigen::VectorXd energyPull;
  Eigen::SparseMatrix<double> gauge;  ///< a form on x that fixes what makes no velocity; or empty
  /// Some x make no velocity that smoothness would charge: a constant added to a scalar potential,
  /// harmonic vector potentials.
  bool hasSilentUnknowns = false;
};

/// row * basis for rows over coefficients: rows over unknowns.
std::vector<SparseRow> throughBasis(const std::vector<SparseRow>& rows, const FitSpace& space,
                                    const Context& context);

/// One kind of field, as a fit sees it. Const members are thread safe.
class FittedField {
 public:
  virtual ~FittedField() = default;

  const FitSpace& space() const { return space_; }
  /// How the form has to be refined.
  BoundaryMode mode() const { return mode_; }

  /// The limit vectors at points, over control coefficients.
  virtual InfluenceRows at(const std::vector<Vec3>& points, const Context& context) const = 0;
  /// Adds the equations that the kind of field brings beside those of guides.
  virtual void addEquations(LeastSquares* problem) const = 0;
  /// Stores the field of the unknowns x with these coefficients, and reports its walls.
  virtual void store(const Eigen::VectorXd& x, const Eigen::VectorXd& coefficients,
                     FitResult* result) const = 0;
  /// Remarks on what the kind of field means for who bakes it; empty: there is nothing to say.
  virtual std::string remark() const = 0;

 protected:
  FitSpace space_;
  BoundaryMode mode_ = BoundaryMode::Open;
};

/// A 2-form with given flux through walls: divergence-free (the derivative of a vector potential)
/// or free. The domain must outlive it, as for all of them.
std::unique_ptr<const FittedField> makeFluxFit(const FitDomain& domain, const Context& context);
/// A 1-form that is the derivative of a potential; closed walls are least-squares equations.
std::unique_ptr<const FittedField> makeCurlFreeFit(const FitDomain& domain, const Context& context);

/// The numbers of a vector, as the values of a cochain.
inline Array<double> toArray(const Eigen::VectorXd& v) {
  return Array<double>(v.data(), v.data() + v.size());
}

}  // namespace octet
