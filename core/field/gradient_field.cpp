// SPDX-License-Identifier: Apache-2.0
#include "gradient_field.h"

#include "../base/parallel.h"
#include "vertex_field.h"

namespace octet {

GradientField makeGradientField(const std::shared_ptr<const Complex>& complex,
                                const Array<Vec3>& positions, const Array<double>& values,
                                Array<Vec3> vectors) {
  Array<Piece<1>::Value> base(values.size());
  parallelFor<std::size_t>(values.size(), [&](std::size_t k) {
    base[k][0] = values[k] - vectors[k].dot(positions[k]) / 2;
  });
  return {ScalarField(std::make_shared<VertexField<1>>(complex, positions, std::move(base))),
          VectorField(std::make_shared<VertexField<3>>(complex, positions, std::move(vectors)))};
}

}  // namespace octet
