// SPDX-License-Identifier: Apache-2.0
#include "refined_document.h"

#include <octet/core/base/error.h>
#include <octet/core/forms/with_degree.h>

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

/// Writes lists a block of entries at a time, with reports in between.
class ReportingWriter {
 public:
  ReportingWriter(const std::string& path, std::size_t total, const Context& context)
      : out(path, DocumentWriter::formatFor(path)), total_(total), context_(context) {}

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
    context_.report({"write document", done, total_, "entries"});
  }

  std::size_t total_, done_ = 0;
  const Context& context_;
};

std::size_t entryCount(const ControlAsset& asset, const Complex& c) {
  std::size_t count = static_cast<std::size_t>(c.vertexCount()) + c.edges.size() +
                      static_cast<std::size_t>(c.facetCount()) + c.tets.size() + c.octs.size();
  for (const Form& form : asset.forms) count += static_cast<std::size_t>(c.count(form.degree));
  return count;
}

}  // namespace

BoundaryMode boundaryMode(const ControlAsset& asset, const Form& form,
                          const BoundaryChoice& choice) {
  if (choice.mode) return *choice.mode;
  if (form.degree == 1) return modeOf<1>(asset, form);
  if (form.degree == 2) return modeOf<2>(asset, form);
  return BoundaryMode::Walls;
}

void writeRefinedDocument(const ControlAsset& asset, const RefinedForms& refined,
                          const std::string& path, const Context& context) {
  const Complex& complex = refined.complex;
  const std::string& note = refined.note;
  ReportingWriter writer(path, entryCount(asset, complex), context);
  DocumentWriter& out = writer.out;
  out.beginObject(note.empty() ? 6 : 7);
  if (!note.empty()) {
    out.key("note");
    out.value(note);
  }
  writer.table("vertices", refined.positions);
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
    const Array<double> values = refined.values(form);
    writer.array("values", values.size(), [&](std::size_t k) { out.value(values[k]); });
    out.endObject();
  }
  out.endObject();
  out.endObject();
  writer.finish();
}

void writeRefinedDocument(const ControlAsset& asset, const Subdivision& subdivision,
                          const BoundaryChoice& boundary, int frame, const std::string& path,
                          const Context& context) {
  const auto values = [&](const Form& form) {
    const BoundaryMode mode = boundaryMode(asset, form, boundary);
    return withDegree(form.degree, [&](auto degree) {
      return subdivision.refine(coefficients<decltype(degree)::value>(asset, form, frame), mode)
          .values();
    });
  };
  writeRefinedDocument(asset,
                       {*subdivision.finest(), subdivision.positions(subdivision.levels()), values,
                        subdivision.note()},
                       path, context);
}

}  // namespace octet
