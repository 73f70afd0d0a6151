// SPDX-License-Identifier: Apache-2.0
#include "fitted_field.h"

#include <cmath>

#include "../base/reported_loop.h"
#include "../topology/mean_edge.h"
#include "smoothness.h"

namespace octet {
namespace {

RefinerOptions refinerOptions(const FitOptions& options) {
  RefinerOptions result;
  result.levels = options.levels;
  result.zeta = options.zeta;
  return result;
}

const FitOptions& checked(const FitOptions& options) {
  if (!(options.smoothness >= 0) || !std::isfinite(options.smoothness)) {
    throw InputError("smoothness", "is not a number that is 0 or more");
  }
  if (!(options.spacing >= 0) || !std::isfinite(options.spacing)) {
    throw InputError("spacing", "is not a number that is 0 or more");
  }
  if (options.kind == FitKind::CurlFree && !options.openFacets.empty()) {
    throw InputError("open facets", "are for fields that are fluxes, not for curl-free ones");
  }
  if (options.kind == FitKind::CurlFree && !options.flux.empty()) {
    throw InputError("given flux", "is for fields that are fluxes, not for curl-free ones");
  }
  return options;
}

}  // namespace

FitDomain::FitDomain(const ControlMesh& cage, const FitOptions& given, const Context& context)
    : options(checked(given)),
      mesh(cage),
      refiner(cage, refinerOptions(given), context.sub(0.5)),
      limit(refiner, context.sub(0.1)),
      edge(meanEdge(complex(), mesh.positions())),
      length(options.smoothness * std::cbrt(volumeOf(complex(), mesh.positions()))) {}

void FitSpace::setCoefficients(RowMatrix newBasis, Eigen::VectorXd newParticular) {
  basis = std::move(newBasis);
  particular = std::move(newParticular);
  energy = Eigen::SparseMatrix<double>(basis.cols(), basis.cols());
  energyPull = Eigen::VectorXd::Zero(basis.cols());
}

void FitSpace::setEnergy(const Eigen::SparseMatrix<double>& onCoefficients) {
  using Matrix = Eigen::SparseMatrix<double>;
  const Matrix columns = basis;
  const Matrix half = onCoefficients * columns;
  energy = Matrix(columns.transpose()) * half;
  energyPull = -(Matrix(half.transpose()) * particular);
}

std::vector<SparseRow> throughBasis(const std::vector<SparseRow>& rows, const FitSpace& space,
                                    const Context& context) {
  std::vector<SparseRow> result(rows.size());
  parallelRanges<std::size_t>(
      rows.size(),
      [&](std::size_t first, std::size_t last) {
        RowSum sum(static_cast<Index>(space.basis.cols()));
        for (std::size_t r = first; r < last; ++r) {
          for (std::size_t k = 0; k < rows[r].size(); ++k) {
            for (FitSpace::RowMatrix::InnerIterator it(space.basis, rows[r].index[k]); it; ++it) {
              sum.add(static_cast<Index>(it.col()), rows[r].weight[k] * it.value());
            }
          }
          result[r] = sum.take();
        }
      },
      context, 256);
  return result;
}

}  // namespace octet
