// SPDX-License-Identifier: Apache-2.0
#include "refined_document.h"

#include <octet/core/base/error.h>
#include <octet/core/boundary_methods/extension.h>

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

/// `refine(form of degree K)` for the degree that the form has.
template <typename Refine>
Array<double> byDegree(const ControlAsset& asset, const Form& form, int frame,
                       const Refine& refine) {
  switch (form.degree) {
    case 0:
      return refine(coefficients<0>(asset, form, frame)).values();
    case 1:
      return refine(coefficients<1>(asset, form, frame)).values();
    case 2:
      return refine(coefficients<2>(asset, form, frame)).values();
    default:
      return refine(coefficients<3>(asset, form, frame)).values();
  }
}

/// Writes lists a block of entries at a time, with reports in between.
class ReportingWriter {
 public:
  ReportingWriter(const std::string& path, std::size_t total, const ProgressCallback& progress)
      : out(path, DocumentWriter::formatFor(path)), total_(total), progress_(progress) {}

  DocumentWriter out;

  /// A key with an array, whose entries `write(k)` writes.
  template <typename Write>
  void array(const char* name, std::size_t size, const Write& write) {
    constexpr std::size_t kBlock = 1 << 16;
    out.key(name);
    out.beginArray(size);
    for (std::size_t k = 0; k < size; ++k) {
      if (k % kBlock == 0) report(done_ + k);
      write(k);
    }
    out.endArray();
    done_ += size;
  }
  template <typename Rows>
  void table(const char* name, const Rows& rows) {
    array(name, rows.size(), [&](std::size_t k) { out.row(rows[k]); });
  }
  void finish() {
    report(total_);
    out.close();
  }

 private:
  void report(std::size_t done) const {
    reportProgress(progress_, {"write document", done, total_, "entries"});
  }

  std::size_t total_, done_ = 0;
  const ProgressCallback& progress_;
};

std::size_t entryCount(const ControlAsset& asset, const Complex& c) {
  std::size_t count = static_cast<std::size_t>(c.vertexCount()) + c.edges.size() +
                      static_cast<std::size_t>(c.facetCount()) + c.tets.size() + c.octs.size();
  for (const Form& form : asset.forms) count += static_cast<std::size_t>(c.count(form.degree));
  return count;
}

/// `valuesOf(form)` are dense coefficients on the finest level, `complex`.
template <typename Values>
void writeDocument(const ControlAsset& asset, const Complex& complex, const Array<Vec3>& positions,
                   const std::string& note, const Values& valuesOf, const std::string& path,
                   const ProgressCallback& progress) {
  ReportingWriter writer(path, entryCount(asset, complex), progress);
  DocumentWriter& out = writer.out;
  out.beginObject(note.empty() ? 6 : 7);
  if (!note.empty()) {
    out.key("note");
    out.value(note);
  }
  writer.table("vertices", positions);
  writer.table("edges", complex.edges);
  writer.array("facets", static_cast<std::size_t>(complex.facetCount()),
               [&](std::size_t f) { out.row(complex.facetVertices(static_cast<Index>(f))); });
  writer.table("tetrahedra", complex.tets);
  writer.table("octahedra", complex.octs);
  out.key("forms");
  out.beginObject(asset.forms.size());
  for (const Form& form : asset.forms) {
    out.key(form.name);
    out.beginObject(2);
    out.key("degree");
    out.value(static_cast<std::int64_t>(form.degree));
    const Array<double> values = valuesOf(form);
    writer.array("values", values.size(), [&](std::size_t k) { out.value(values[k]); });
    out.endObject();
  }
  out.endObject();
  out.endObject();
  writer.finish();
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

std::optional<BoundaryMethod> boundaryMethod(BoundaryChoice choice) {
  switch (choice) {
    case BoundaryChoice::Simple:
      return BoundaryMethod::Simple;
    case BoundaryChoice::Projection:
      return BoundaryMethod::Projection;
    case BoundaryChoice::Expansion:
      return BoundaryMethod::Expansion;
    default:
      return std::nullopt;
  }
}

const char* boundaryName(BoundaryChoice choice) {
  constexpr const char* kNames[] = {"auto", "walls", "open", "simple", "projection", "expansion"};
  return kNames[static_cast<int>(choice)];
}

std::string methodNote(const MethodRefiner& refiner) {
  if (refiner.commutes()) return "";
  switch (refiner.method()) {
    case BoundaryMethod::Simple:
      return "simple: coefficients on the boundary are 0, so there is divergence and curl that the "
             "form does not have";
    case BoundaryMethod::Projection:
      return "projection: coefficients at the boundary are fitted, so there is divergence and curl "
             "that the form does not have";
    default:
      return "expansion: its virtual layer fills a gap in the mesh, and around it there is "
             "divergence and curl that the form does not have";
  }
}

void writeRefinedDocument(const ControlAsset& asset, const Refiner& refiner, BoundaryChoice choice,
                          int frame, const std::string& path, const ProgressCallback& progress) {
  const auto values = [&](const Form& form) {
    const BoundaryMode mode = boundaryMode(asset, form, choice);
    return byDegree(asset, form, frame,
                    [&](auto coarse) { return refiner.refine(std::move(coarse), mode); });
  };
  writeDocument(asset, refiner.finest(), refiner.positions(refiner.levels()), "", values, path,
                progress);
}

void writeRefinedDocument(const ControlAsset& asset, const MethodRefiner& refiner, int frame,
                          const std::string& path, const ProgressCallback& progress) {
  const auto values = [&](const Form& form) {
    return byDegree(asset, form, frame, [&](const auto& coarse) { return refiner.refine(coarse); });
  };
  const int finest = refiner.levels();
  writeDocument(asset, refiner.complex(finest), refiner.positions(finest), methodNote(refiner),
                values, path, progress);
}

void writeExpandedDocument(const ControlAsset& asset, int frame, const std::string& path,
                           const ProgressCallback& progress) {
  const VirtualLayer layer(asset.mesh);
  const ControlMesh expanded = ControlMesh::build(layer.expanded);
  const Extension extension(asset.mesh, layer, expanded);
  const auto values = [&](const Form& form) {
    return byDegree(asset, form, frame,
                    [&](const auto& coarse) { return extension.apply(coarse); });
  };
  writeDocument(asset, *expanded.complex(), expanded.positions(), "", values, path, progress);
}

}  // namespace octet
