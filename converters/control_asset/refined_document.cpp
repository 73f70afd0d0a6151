// SPDX-License-Identifier: Apache-2.0
#include "refined_document.h"

#include <octet/core/base/error.h>

#include "document.h"

namespace octet {
namespace {

template <int K>
BoundaryMode modeOf(const ControlAsset& asset, const Form& form) {
  if (!form.animated()) {
    return automaticMode(*asset.mesh.complex(), coefficients<K>(asset, form));
  }
  for (const auto& [frame, values] : form.frames) {
    const auto mode = automaticMode(*asset.mesh.complex(), coefficients<K>(asset, form, frame));
    if (mode == BoundaryMode::Open) return mode;
  }
  return BoundaryMode::Walls;
}

template <int K>
Array<double> refined(const ControlAsset& asset, const Refiner& refiner, const Form& form,
                      BoundaryMode mode, int frame) {
  return refiner.refine(coefficients<K>(asset, form, frame), mode).values();
}

}  // namespace

BoundaryMode boundaryMode(const ControlAsset& asset, const Form& form, BoundaryChoice choice) {
  if (choice != BoundaryChoice::Auto) {
    return choice == BoundaryChoice::Walls ? BoundaryMode::Walls : BoundaryMode::Open;
  }
  switch (form.degree) {
    case 1:
      return modeOf<1>(asset, form);
    case 2:
      return modeOf<2>(asset, form);
    default:
      return BoundaryMode::Walls;
  }
}

void writeRefinedDocument(const ControlAsset& asset, const Refiner& refiner, BoundaryChoice choice,
                          int frame, const std::string& path) {
  const Complex& complex = refiner.finest();
  DocumentWriter out(path, DocumentWriter::formatFor(path));
  out.beginObject(6);
  out.table("vertices", refiner.positions(refiner.levels()));
  out.table("edges", complex.edges);
  out.key("facets");
  out.beginArray(complex.facetCount());
  for (Index f = 0; f < complex.facetCount(); ++f) out.row(complex.facetVertices(f));
  out.endArray();
  out.table("tetrahedra", complex.tets);
  out.table("octahedra", complex.octs);
  out.key("forms");
  out.beginObject(asset.forms.size());
  for (const Form& form : asset.forms) {
    const BoundaryMode mode = boundaryMode(asset, form, choice);
    out.key(form.name);
    out.beginObject(2);
    out.key("degree");
    out.value(static_cast<std::int64_t>(form.degree));
    const auto values = form.degree == 0   ? refined<0>(asset, refiner, form, mode, frame)
                        : form.degree == 1 ? refined<1>(asset, refiner, form, mode, frame)
                        : form.degree == 2 ? refined<2>(asset, refiner, form, mode, frame)
                                           : refined<3>(asset, refiner, form, mode, frame);
    out.list("values", values);
    out.endObject();
  }
  out.endObject();
  out.endObject();
  out.close();
}

}  // namespace octet
