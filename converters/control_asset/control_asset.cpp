// SPDX-License-Identifier: Apache-2.0
#include "control_asset.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <set>

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

#include "document.h"

namespace octet {
namespace {

/// Largest value of a form: grids hold 32-bit floats.
constexpr double kLargestValue = 1e30;

std::string at(const std::string& place, std::size_t k) {
  return place + "[" + std::to_string(k) + "]";
}

std::string join(const std::string& place, const std::string& key) {
  return place.empty() ? key : place + "." + key;
}

/// Keys that mean nothing are left alone, unless they look like a slip for one that does.
void checkKeys(const DocumentValue& object, const std::string& place,
               const std::vector<std::string>& known) {
  for (const std::string& key : object.as<DocumentObject>()->keys) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string meant = nearestName(key, known);
    if (meant.size() > 3) {
      throw InputError(join(place, key), "is not a key; did you mean \"" + meant + "\"?");
    }
  }
}

const DocumentValue& require(const DocumentValue& object, const std::string& place,
                             const std::string& key) {
  const DocumentValue* value = object.find(key);
  if (!value) throw InputError(place, "key \"" + key + "\" is missing");
  return *value;
}

template <typename T>
const T& expect(const DocumentValue& value, const std::string& place, const char* what) {
  const T* result = value.as<T>();
  if (!result) throw InputError(place, std::string("is not ") + what);
  return *result;
}

const std::string& text(const DocumentValue& value, const std::string& place) {
  return expect<std::string>(value, place, "a string");
}

double finiteNumber(const DocumentValue& value, const std::string& place) {
  const double number = expect<double>(value, place, "a number");
  if (!std::isfinite(number)) throw InputError(place, "is not a finite number");
  return number;
}

std::int64_t integer(double x, const std::string& place) {
  if (!(std::abs(x) < 9e15) || x != std::floor(x)) {
    throw InputError(place, "is not an integer in range");
  }
  return static_cast<std::int64_t>(x);
}

/// Vertex indices are checked for range where they are used; here only that they fit.
Index index(double x, const std::string& place) {
  const std::int64_t i = integer(x, place);
  if (i < 0 || i > INT32_MAX) {
    throw InputError(place, "index " + std::to_string(i) + " is out of range");
  }
  return static_cast<Index>(i);
}

const NumberList& numberList(const DocumentValue& value, const std::string& place) {
  const auto& list = expect<NumberList>(value, place, "an array of numbers");
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (!std::isfinite(list[k])) throw InputError(at(place, k), "is not a finite number");
  }
  return list;
}

/// Calls row(k, first, size) for every row of an array of arrays of numbers.
template <typename Row>
void visitRows(const DocumentValue& value, const std::string& place, const Row& row) {
  if (value.isEmptyArray()) return;
  if (value.as<NumberList>()) throw InputError(at(place, 0), "is not an array of numbers");
  const auto& table = expect<NumberTable>(value, place, "an array of arrays of numbers");
  std::size_t begin = 0;
  for (std::size_t k = 0; k < table.rowEnds.size(); ++k) {
    row(k, table.numbers.data() + begin, table.rowEnds[k] - begin);
    begin = table.rowEnds[k];
  }
}

template <std::size_t N>
Array<std::array<Index, N>> indexRows(const DocumentValue* value, const std::string& place) {
  Array<std::array<Index, N>> rows;
  if (!value) return rows;
  visitRows(*value, place, [&](std::size_t k, const double* row, std::size_t n) {
    if (n != N) {
      throw InputError(at(place, k),
                       "has " + std::to_string(n) + " vertices, not " + std::to_string(N));
    }
    rows.emplace_back();
    for (std::size_t i = 0; i < N; ++i) rows.back()[i] = index(row[i], at(at(place, k), i));
  });
  return rows;
}

ControlMeshInput readMesh(const DocumentValue& document) {
  ControlMeshInput input;
  const DocumentValue& vertices = require(document, "", "vertices");
  visitRows(vertices, "vertices", [&](std::size_t k, const double* row, std::size_t n) {
    if (n != 3) {
      throw InputError(at("vertices", k), "has " + std::to_string(n) + " coordinates, not 3");
    }
    input.vertices.emplace_back(row[0], row[1], row[2]);
  });
  if (input.vertices.size() > INT32_MAX)
    throw InputError("vertices", "are too many to be numbered");
  input.tets = indexRows<4>(document.find("tetrahedra"), "tetrahedra");
  input.octs = indexRows<6>(document.find("octahedra"), "octahedra");
  if (const DocumentValue* creases = document.find("creases")) {
    const auto rows = indexRows<2>(creases, "creases");
    input.creases.emplace(rows.begin(), rows.end());
  }
  if (const DocumentValue* corners = document.find("corners")) {
    const auto& list = numberList(*corners, "corners");
    for (std::size_t k = 0; k < list.size(); ++k) {
      input.corners.push_back(index(list[k], at("corners", k)));
    }
  }
  return input;
}

AssetUnits readUnits(const DocumentValue& document) {
  AssetUnits units;
  if (const DocumentValue* up = document.find("up_axis")) {
    const std::string& axis = text(*up, "up_axis");
    if (axis != "Y" && axis != "Z") {
      throw InputError("up_axis", "\"" + axis + "\" is neither \"Y\" nor \"Z\"");
    }
    units.upAxis = axis[0];
  }
  const auto positive = [&](const char* key, double* out) {
    const DocumentValue* value = document.find(key);
    if (!value) return;
    *out = finiteNumber(*value, key);
    if (!(*out > 0)) throw InputError(key, "is not positive");
  };
  positive("meters_per_unit", &units.metersPerUnit);
  positive("frames_per_second", &units.framesPerSecond);
  return units;
}

bool isControlCharacter(char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; }

/// Finds the simplices that forms list in the control mesh.
class SimplexFinder {
 public:
  explicit SimplexFinder(const ControlMesh& mesh) : mesh_(mesh) {}

  /// Dense index of a listed simplex, and whether it is listed along its stored orientation.
  std::pair<Index, std::int8_t> find(int degree, const std::vector<Index>& v) {
    const Index n = mesh_.complex()->vertexCount();
    for (const Index x : v) {
      if (x >= n) {
        throw InputError("", "vertex " + std::to_string(x) + " is out of range, there are " +
                                 std::to_string(n) + " vertices");
      }
      if (std::count(v.begin(), v.end(), x) > 1) {
        throw InputError("", "vertex " + std::to_string(x) + " is repeated");
      }
    }
    if (degree == 0) return {v[0], 1};
    if (degree == 1) {
      const EdgeRef e = mesh_.edge(v[0], v[1]);
      return {e.index(), e.reversed() ? -1 : 1};
    }
    if (degree == 2) {
      const FacetRef f = mesh_.facet(v[0], v[1], v[2]);
      return {f.index(), f.sign() < 0 ? -1 : 1};
    }
    return {cell(v), 1};
  }

 private:
  Index cell(const std::vector<Index>& v) const {
    const Complex& complex = *mesh_.complex();
    Index found = kNone;
    std::string stored;
    complex.visitVertexStar(v[0], [&](const CellAtVertex& star) {
      if (static_cast<std::size_t>(complex.cellVertexCount(star.cell)) != v.size()) return;
      bool same = true, permuted = true;
      for (std::size_t i = 0; i < v.size(); ++i) {
        const Index own = complex.cellVertex(star.cell, static_cast<int>(i));
        same &= own == v[i];
        permuted &= std::find(v.begin(), v.end(), own) != v.end();
      }
      if (same) found = star.cell;
      if (permuted) stored = ControlMesh::cellName(complex, star.cell);
    });
    if (found != kNone) return found;
    if (!stored.empty()) {
      throw InputError("", "lists the vertices of " + stored + " in another order than stored");
    }
    throw InputError("", "the mesh has no such cell");
  }

  const ControlMesh& mesh_;
};

Form readForm(const DocumentValue& object, const std::string& place, SimplexFinder* finder) {
  expect<DocumentObject>(object, place, "an object");
  checkKeys(object, place, {"name", "degree", "unit", "simplices", "values", "frames"});
  Form form;
  form.name = text(require(object, place, "name"), place + ".name");
  if (form.name.empty()) throw InputError(place + ".name", "is empty");
  if (std::any_of(form.name.begin(), form.name.end(), isControlCharacter)) {
    throw InputError(place + ".name", "has a control character, such as a line break");
  }
  const double degree = finiteNumber(require(object, place, "degree"), place + ".degree");
  if (degree != 0 && degree != 1 && degree != 2 && degree != 3) {
    throw InputError(place + ".degree", "is not 0, 1, 2 or 3");
  }
  form.degree = static_cast<int>(degree);
  if (const DocumentValue* unit = object.find("unit")) {
    form.unit = text(*unit, place + ".unit");
  }

  const std::string simplices = place + ".simplices";
  std::set<Index> listed;
  visitRows(require(object, place, "simplices"), simplices,
            [&](std::size_t k, const double* row, std::size_t n) {
              const std::string where = at(simplices, k);
              const bool fits = form.degree < 3 ? n == static_cast<std::size_t>(form.degree) + 1
                                                : n == 4 || n == 6;
              if (!fits) {
                throw InputError(where, "has " + std::to_string(n) +
                                            " vertices, which no simplex of degree " +
                                            std::to_string(form.degree) + " has");
              }
              std::vector<Index> vertices;
              for (std::size_t i = 0; i < n; ++i) vertices.push_back(index(row[i], at(where, i)));
              try {
                const auto [simplex, sign] = finder->find(form.degree, vertices);
                form.simplices.push_back(simplex);
                form.signs.push_back(sign);
              } catch (const InputError& e) {
                throw InputError(where, e.reason());
              }
              if (!listed.insert(form.simplices.back()).second) {
                throw InputError(where, "is listed twice");
              }
            });

  const auto readValues = [&](const DocumentValue& value, const std::string& where) {
    const auto& list = numberList(value, where);
    if (list.size() != form.simplices.size()) {
      throw InputError(where, "has " + std::to_string(list.size()) + " numbers for " +
                                  std::to_string(form.simplices.size()) + " simplices");
    }
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (std::abs(list[k]) > kLargestValue) throw InputError(at(where, k), "is larger than 1e30");
    }
    return list;
  };
  const DocumentValue* values = object.find("values");
  const DocumentValue* frames = object.find("frames");
  if (!values == !frames) {
    throw InputError(place, values ? "has both \"values\" and \"frames\""
                                   : "has neither \"values\" nor \"frames\"");
  }
  if (values) {
    form.values = readValues(*values, place + ".values");
    return form;
  }
  const auto& byFrame = expect<DocumentObject>(*frames, place + ".frames", "an object");
  if (byFrame.keys.empty()) throw InputError(place + ".frames", "is empty");
  for (std::size_t k = 0; k < byFrame.keys.size(); ++k) {
    const std::string& key = byFrame.keys[k];
    const std::string where = place + ".frames[\"" + key + "\"]";
    int frame = 0;
    const auto [end, status] = std::from_chars(key.data(), key.data() + key.size(), frame);
    if (status != std::errc() || end != key.data() + key.size() || std::abs(frame) > kLastFrame) {
      throw InputError(where, "is not named by a frame number");
    }
    if (!form.frames.emplace(frame, readValues(byFrame.values[k], where)).second) {
      throw InputError(where, "appears twice");
    }
  }
  return form;
}

ControlAsset readDocumentAsAsset(const DocumentValue& document) {
  checkKeys(document, "",
            {"octet", "name", "up_axis", "meters_per_unit", "frames_per_second", "vertices",
             "tetrahedra", "octahedra", "creases", "corners", "forms"});
  if (const DocumentValue* version = document.find("octet")) {
    if (finiteNumber(*version, "octet") != 1) {
      throw InputError("octet", "format version is not 1, the only one known");
    }
  }
  ControlAsset asset;
  if (const DocumentValue* name = document.find("name")) {
    asset.name = text(*name, "name");
  }
  asset.units = readUnits(document);
  asset.mesh = ControlMesh::build(readMesh(document));
  const DocumentValue* forms = document.find("forms");
  if (!forms || forms->isEmptyArray()) return asset;
  const auto& list = expect<DocumentArray>(*forms, "forms", "an array of objects");
  SimplexFinder finder(asset.mesh);
  for (std::size_t k = 0; k < list.size(); ++k) {
    asset.forms.push_back(readForm(list[k], at("forms", k), &finder));
    for (std::size_t j = 0; j < k; ++j) {
      if (asset.forms[j].name == asset.forms[k].name) {
        throw InputError(at("forms", k) + ".name",
                         "\"" + asset.forms[k].name + "\" is taken by " + at("forms", j));
      }
    }
  }
  return asset;
}

/// The simplices of a form as the asset lists them.
std::vector<Index> listedVertices(const Complex& complex, const Form& form, std::size_t k) {
  const Index i = form.simplices[k];
  std::vector<Index> v;
  if (form.degree == 0) {
    v = {i};
  } else if (form.degree == 1) {
    v.assign(complex.edges[i].begin(), complex.edges[i].end());
  } else if (form.degree == 2) {
    const auto t = complex.facetVertices(i);
    v.assign(t.begin(), t.end());
  } else {
    for (int j = 0; j < complex.cellVertexCount(i); ++j) v.push_back(complex.cellVertex(i, j));
  }
  if (form.signs[k] < 0) std::swap(v[0], v[1]);
  return v;
}

}  // namespace

const Form& ControlAsset::form(const std::string& wanted) const {
  std::vector<std::string> names;
  for (const Form& f : forms) {
    if (f.name == wanted) return f;
    names.push_back(f.name);
  }
  throw InputError("", "there is no form \"" + wanted + "\"; the asset has " +
                           (names.empty() ? "none" : listOf(names)) + didYouMean(wanted, names));
}

std::optional<std::pair<int, int>> ControlAsset::frameRange() const {
  std::optional<std::pair<int, int>> range;
  for (const Form& f : forms) {
    if (!f.animated()) continue;
    const int first = f.frames.begin()->first, last = f.frames.rbegin()->first;
    range = range ? std::pair{std::min(range->first, first), std::max(range->second, last)}
                  : std::pair{first, last};
  }
  return range;
}

ControlAsset readControlAsset(const std::string& path) {
  const DocumentValue document = readDocument(path, {"control asset"});
  try {
    ControlAsset asset = readDocumentAsAsset(document);
    if (asset.name.empty()) {
      std::string stem = std::filesystem::path(path).filename().string();
      asset.name = stem.substr(0, stem.find('.'));
    }
    return asset;
  } catch (const InputError& e) {
    throw e.inFile(path);
  }
}

void writeControlAsset(const ControlAsset& asset, const std::string& path, const Context& context) {
  const Complex& complex = *asset.mesh.complex();
  std::vector<std::array<Index, 2>> creases;
  for (Index e = 0; e < complex.edgeCount(); ++e) {
    if (complex.edgeFlags[e] & kOnCrease) creases.push_back(complex.edges[e]);
  }
  DocumentWriter out(path, DocumentWriter::formatFor(path), context);
  out.beginObject(11);
  out.key("octet");
  out.value(std::int64_t{1});
  out.key("name");
  out.value(asset.name);
  out.key("up_axis");
  out.value(std::string_view(&asset.units.upAxis, 1));
  out.key("meters_per_unit");
  out.value(asset.units.metersPerUnit);
  out.key("frames_per_second");
  out.value(asset.units.framesPerSecond);
  out.table("vertices", asset.mesh.positions());
  out.table("tetrahedra", complex.tets);
  out.table("octahedra", complex.octs);
  out.table("creases", creases);
  out.list("corners", asset.mesh.corners());
  out.key("forms");
  out.beginArray(asset.forms.size());
  for (const Form& form : asset.forms) {
    out.beginObject(5);
    out.key("name");
    out.value(form.name);
    out.key("degree");
    out.value(static_cast<std::int64_t>(form.degree));
    out.key("unit");
    out.value(form.unit);
    out.key("simplices");
    out.beginArray(form.simplices.size());
    for (std::size_t k = 0; k < form.simplices.size(); ++k) {
      out.row(listedVertices(complex, form, k));
    }
    out.endArray();
    if (form.animated()) {
      out.key("frames");
      out.beginObject(form.frames.size());
      for (const auto& [frame, values] : form.frames) out.list(std::to_string(frame), values);
      out.endObject();
    } else {
      out.list("values", form.values);
    }
    out.endObject();
  }
  out.endArray();
  out.endObject();
  out.close();
}

template <int K>
Cochain<K> coefficients(const ControlAsset& asset, const Form& form, int frame) {
  if (form.degree != K) {
    throw InputError("", "form \"" + form.name + "\" has degree " + std::to_string(form.degree) +
                             ", not " + std::to_string(K));
  }
  const std::vector<double>* values = &form.values;
  if (form.animated()) {
    auto after = form.frames.upper_bound(frame);
    if (after != form.frames.begin()) --after;
    values = &after->second;
  }
  Cochain<K> result(*asset.mesh.complex());
  for (std::size_t k = 0; k < form.simplices.size(); ++k) {
    result[form.simplices[k]] = form.signs[k] * (*values)[k];
  }
  return result;
}

template <int K>
Form makeForm(std::string name, const Cochain<K>& coefficients, std::string unit) {
  Form form;
  form.name = std::move(name);
  form.degree = K;
  form.unit = std::move(unit);
  for (Index i = 0; i < coefficients.size(); ++i) {
    if (coefficients[i] == 0) continue;
    form.simplices.push_back(i);
    form.signs.push_back(1);
    form.values.push_back(coefficients[i]);
  }
  return form;
}

template Cochain<0> coefficients<0>(const ControlAsset&, const Form&, int);
template Cochain<1> coefficients<1>(const ControlAsset&, const Form&, int);
template Cochain<2> coefficients<2>(const ControlAsset&, const Form&, int);
template Cochain<3> coefficients<3>(const ControlAsset&, const Form&, int);
template Form makeForm<0>(std::string, const Cochain<0>&, std::string);
template Form makeForm<1>(std::string, const Cochain<1>&, std::string);
template Form makeForm<2>(std::string, const Cochain<2>&, std::string);
template Form makeForm<3>(std::string, const Cochain<3>&, std::string);

}  // namespace octet
