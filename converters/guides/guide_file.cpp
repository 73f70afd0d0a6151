// SPDX-License-Identifier: Apache-2.0
#include "guide_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <optional>

#include <octet/core/base/error.h>

#include "../control_asset/document.h"
#include "text_lines.h"

namespace octet {
namespace {

std::string lineName(int number) { return "line " + std::to_string(number); }

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// ---- OBJ
// ------------------------------------------------------------------------------------------

class ObjReader {
 public:
  ObjReader(std::string path, double speed) : path_(std::move(path)), speed_(speed) {}

  Guides read() {
    visitLines(path_, [&](std::string_view text, int number) {
      const auto words = splitText(text.substr(0, text.find('#')), " \t");
      if (words.empty()) return;
      if (words[0] == "v") addVertex(words, number);
      if (words[0] == "l") addLine(words, number);
      if ((words[0] == "o" || words[0] == "g") && words.size() > 1) name_ = std::string(words[1]);
    });
    if (guides_.curves.empty()) throw InputError(path_, "", "has no polylines (l elements)");
    return std::move(guides_);
  }

 private:
  void addVertex(const std::vector<std::string_view>& words, int number) {
    if (words.size() < 4) throw InputError(path_, lineName(number), "a vertex needs x, y and z");
    Vec3 p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[static_cast<Index>(k)] = parseNumber(words[k + 1], path_, lineName(number));
    }
    vertices_.push_back(p);
    lines_.push_back(number);
  }

  void addLine(const std::vector<std::string_view>& words, int number) {
    GuideCurve curve;
    curve.file = path_;
    curve.speeds = {speed_};
    curve.name = name_.empty() ? "curve " + std::to_string(guides_.curves.size() + 1) : name_;
    for (std::size_t k = 1; k < words.size(); ++k) {
      // "vertex/texture": the first is meant; below 0 counts back from the latest.
      const double index =
          parseNumber(words[k].substr(0, words[k].find('/')), path_, lineName(number));
      const double count = static_cast<double>(vertices_.size());
      const double at = index < 0 ? count + index : index - 1;
      if (!(at >= 0 && at < count) || at != std::floor(at)) {
        throw InputError(path_, lineName(number),
                         "\"" + std::string(words[k]) + "\" is none of the " +
                             std::to_string(vertices_.size()) + " vertices before");
      }
      curve.points.push_back(vertices_[static_cast<std::size_t>(at)]);
      curve.places.push_back(lineName(lines_[static_cast<std::size_t>(at)]));
    }
    if (curve.points.size() < 2) {
      throw InputError(path_, lineName(number), "a polyline needs two vertices or more");
    }
    // Mesh editors write a curve edge by edge.
    GuideCurve* last = guides_.curves.empty() ? nullptr : &guides_.curves.back();
    if (last && last->name == curve.name && last->places.back() == curve.places.front() &&
        last->points.back() == curve.points.front()) {
      last->points.insert(last->points.end(), curve.points.begin() + 1, curve.points.end());
      last->places.insert(last->places.end(), curve.places.begin() + 1, curve.places.end());
    } else {
      guides_.curves.push_back(std::move(curve));
    }
  }

  std::string path_, name_;
  double speed_;
  std::vector<Vec3> vertices_;
  std::vector<int> lines_;
  Guides guides_;
};

// ---- CSV
// ------------------------------------------------------------------------------------------

class CsvReader {
 public:
  CsvReader(std::string path, double speed) : path_(std::move(path)), speed_(speed) {}

  Guides read() {
    visitLines(path_, [&](std::string_view text, int number) {
      text = trimmed(text.substr(0, text.find('#')));
      if (text.empty()) return;
      if (names_.empty()) {
        readHeader(text, number);
      } else {
        readRow(text, number);
      }
    });
    if (guides_.curves.empty() && guides_.vectors.empty()) {
      throw InputError(path_, "", "has no guides");
    }
    return std::move(guides_);
  }

 private:
  void readHeader(std::string_view text, int number) {
    for (const char c : {',', ';', '\t'}) {
      if (text.find(c) != text.npos) {
        separator_ = c;
        break;
      }
    }
    static const std::vector<std::string> kKnown = {"curve", "name",   "x",  "y",  "z",
                                                    "speed", "weight", "vx", "vy", "vz"};
    for (const std::string_view part : splitText(text, std::string(1, separator_))) {
      names_.push_back(lower(part));
      if (std::find(kKnown.begin(), kKnown.end(), names_.back()) == kKnown.end()) {
        throw InputError(path_, lineName(number),
                         "column \"" + std::string(part) +
                             "\" is none of curve, name, x, y, z, speed, weight, vx, vy, vz");
      }
    }
    for (const char* needed : {"x", "y", "z"}) {
      if (!column(needed)) {
        throw InputError(path_, lineName(number),
                         std::string("the header has no column \"") + needed + "\"");
      }
    }
  }

  std::optional<std::size_t> column(const std::string& name) const {
    const auto at = std::find(names_.begin(), names_.end(), name);
    if (at == names_.end()) return std::nullopt;
    return static_cast<std::size_t>(at - names_.begin());
  }

  std::string_view cell(const std::string& name) const {
    const auto k = column(name);
    return k ? cells_[*k] : std::string_view();
  }

  double number(const std::string& name, int line, std::optional<double> otherwise) const {
    if (cell(name).empty() && otherwise) return *otherwise;
    return parseNumber(cell(name), path_, lineName(line) + ", column " + name);
  }

  void readRow(std::string_view text, int line) {
    cells_ = splitText(text, std::string(1, separator_));
    if (cells_.size() != names_.size()) {
      throw InputError(path_, lineName(line),
                       std::to_string(cells_.size()) + " columns, but the header has " +
                           std::to_string(names_.size()));
    }
    const Vec3 p(number("x", line, {}), number("y", line, {}), number("z", line, {}));
    const double weight = number("weight", line, 1.0);
    if (cell("curve").empty()) {
      addVector(p, weight, line);
      return;
    }
    const std::string name(cell("curve"));
    if (guides_.curves.empty() || guides_.curves.back().name != name || inVectors_) {
      guides_.curves.push_back({name, {}, {}, weight, path_, {}});
    }
    inVectors_ = false;
    GuideCurve& curve = guides_.curves.back();
    if (weight != curve.weight) {
      throw InputError(path_, lineName(line), "the weight differs within curve \"" + name + "\"");
    }
    curve.points.push_back(p);
    curve.speeds.push_back(number("speed", line, speed_));
    curve.places.push_back(lineName(line));
  }

  void addVector(const Vec3& p, double weight, int line) {
    inVectors_ = true;
    if (!column("vx") || !column("vy") || !column("vz")) {
      throw InputError(path_, lineName(line),
                       "belongs to no curve, and a vector needs columns vx, vy, vz");
    }
    GuideVector vector;
    vector.name = cell("name").empty() ? "vector " + std::to_string(guides_.vectors.size() + 1)
                                       : std::string(cell("name"));
    vector.point = p;
    vector.value = Vec3(number("vx", line, {}), number("vy", line, {}), number("vz", line, {}));
    vector.weight = weight;
    vector.file = path_;
    vector.place = lineName(line);
    guides_.vectors.push_back(std::move(vector));
  }

  std::string path_;
  double speed_;
  char separator_ = ',';
  std::vector<std::string> names_;
  std::vector<std::string_view> cells_;
  bool inVectors_ = false;
  Guides guides_;
};

// ---- JSON
// -----------------------------------------------------------------------------------------

/// "line 7, curves[0].points[2]"; the line is unknown in CBOR.
std::string placeAt(int line, const std::string& place) {
  return line > 0 ? lineName(line) + ", " + place : place;
}

std::string rowPlace(const NumberTable& table, const std::string& name, std::size_t row) {
  return placeAt(table.rowLines[row], name + "[" + std::to_string(row) + "]");
}

/// A value and its path in the document, "curves[0].speed".
struct Located {
  const DocumentValue& value;
  std::string path;

  std::string place() const { return placeAt(value.line, path); }
};

class JsonReader {
 public:
  JsonReader(std::string path, double speed) : path_(std::move(path)), speed_(speed) {}

  Guides read() {
    const DocumentValue document = readDocument(path_, {"guide file", /*rowLines=*/true});
    checkKeys({document, ""}, {"curves", "vectors"});
    visitObjects(document, "curves", [&](const Located& curve) { addCurve(curve); });
    visitObjects(document, "vectors", [&](const Located& vector) { addVector(vector); });
    if (guides_.curves.empty() && guides_.vectors.empty()) {
      throw InputError(path_, "", "has no guides");
    }
    return std::move(guides_);
  }

 private:
  [[noreturn]] void fail(const Located& at, const std::string& reason) const {
    throw InputError(path_, at.place(), reason);
  }

  template <typename Visit>
  void visitObjects(const DocumentValue& document, const std::string& key, const Visit& visit) {
    const DocumentValue* list = document.find(key);
    if (!list || list->isEmptyArray()) return;
    const auto* elements = list->as<DocumentArray>();
    if (!elements) fail({*list, key}, "is not a list of objects");
    for (std::size_t k = 0; k < elements->size(); ++k) {
      const Located element{(*elements)[k], key + "[" + std::to_string(k) + "]"};
      if (!element.value.as<DocumentObject>()) fail(element, "is not an object");
      visit(element);
    }
  }

  void checkKeys(const Located& object, const std::vector<std::string>& known) const {
    const auto& [keys, values] = *object.value.as<DocumentObject>();
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (std::find(known.begin(), known.end(), keys[k]) == known.end()) {
        fail(member(object, values[k], keys[k]), "is not known");
      }
    }
  }

  static Located member(const Located& object, const DocumentValue& value, const std::string& key) {
    return {value, object.path.empty() ? key : object.path + "." + key};
  }

  std::string name(const Located& object) const {
    const DocumentValue* value = object.value.find("name");
    if (!value) return object.path;
    const auto* text = value->as<std::string>();
    if (!text) fail(member(object, *value, "name"), "is not text");
    return *text;
  }

  double number(const Located& object, const char* key, double otherwise) const {
    const DocumentValue* value = object.value.find(key);
    if (!value) return otherwise;
    const auto* number = value->as<double>();
    if (!number) fail(member(object, *value, key), "is not a number");
    return *number;
  }

  Vec3 vector(const Located& object, const char* key) const {
    const DocumentValue* value = object.value.find(key);
    if (!value) fail(object, std::string("has no ") + key);
    const auto* list = value->as<NumberList>();
    if (!list || list->size() != 3) {
      fail(member(object, *value, key), "is not a list of three numbers");
    }
    return {(*list)[0], (*list)[1], (*list)[2]};
  }

  void addCurve(const Located& object) {
    checkKeys(object, {"name", "points", "speed", "speeds", "weight"});
    GuideCurve curve;
    curve.name = name(object);
    curve.file = path_;
    curve.weight = number(object, "weight", 1);
    addPoints(object, &curve);
    if (const DocumentValue* speeds = object.value.find("speeds")) {
      if (object.value.find("speed")) fail(object, "has both speed and speeds");
      const auto* list = speeds->as<NumberList>();
      if (!list) fail(member(object, *speeds, "speeds"), "is not a list of numbers");
      curve.speeds = *list;
    } else {
      curve.speeds = {number(object, "speed", speed_)};
    }
    guides_.curves.push_back(std::move(curve));
  }

  void addPoints(const Located& object, GuideCurve* curve) const {
    const DocumentValue* value = object.value.find("points");
    if (!value) fail(object, "has no points");
    const Located table = member(object, *value, "points");
    const auto* points = value->as<NumberTable>();
    if (!points) fail(table, "is not a list of [x, y, z]");
    std::size_t first = 0;
    for (std::size_t k = 0; k < points->rowEnds.size(); ++k) {
      const std::string place = rowPlace(*points, table.path, k);
      if (points->rowEnds[k] - first != 3) throw InputError(path_, place, "is not [x, y, z]");
      curve->points.emplace_back(points->numbers[first], points->numbers[first + 1],
                                 points->numbers[first + 2]);
      curve->places.push_back(place);
      first = points->rowEnds[k];
    }
  }

  void addVector(const Located& object) {
    checkKeys(object, {"name", "point", "value", "weight"});
    GuideVector result;
    result.name = name(object);
    result.point = vector(object, "point");
    result.value = vector(object, "value");
    result.weight = number(object, "weight", 1);
    result.file = path_;
    result.place = object.place();
    guides_.vectors.push_back(std::move(result));
  }

  std::string path_;
  double speed_;
  Guides guides_;
};

}  // namespace

Guides readGuides(const std::string& path, double speed) {
  const std::string extension = lower(std::filesystem::path(path).extension().string());
  if (extension == ".obj") return ObjReader(path, speed).read();
  if (extension == ".csv") return CsvReader(path, speed).read();
  if (extension == ".json") return JsonReader(path, speed).read();
  throw InputError(path, "", "guides are read from .obj, .csv and .json");
}

std::map<Index, double> readGivenFlux(const std::string& path, const ControlMesh& mesh) {
  const DocumentValue document = readDocument(path, {"file of given fluxes", /*rowLines=*/true});
  const auto fail = [&](const std::string& place, const std::string& reason) {
    throw InputError(path, place, reason);
  };
  const auto* simplices = document.member<NumberTable>("simplices");
  const auto* values = document.member<NumberList>("values");
  if (!simplices) fail("simplices", "is not a list of [a, b, c]");
  if (!values) fail("values", "is not a list of numbers");
  if (values->size() != simplices->rowEnds.size()) {
    fail("values", std::to_string(values->size()) + " values for " +
                       std::to_string(simplices->rowEnds.size()) + " simplices");
  }
  const Complex& c = *mesh.complex();
  std::map<Index, double> result;
  std::size_t first = 0;
  for (std::size_t k = 0; k < simplices->rowEnds.size(); ++k) {
    const std::string place = rowPlace(*simplices, "simplices", k);
    std::array<Index, 3> v{};
    if (simplices->rowEnds[k] - first != 3) fail(place, "is not [a, b, c]");
    for (std::size_t i = 0; i < 3; ++i) {
      const double x = simplices->numbers[first + i];
      if (!(x >= 0 && x < c.vertexCount()) || x != std::floor(x)) {
        fail(place, "a vertex is out of range");
      }
      v[i] = static_cast<Index>(x);
    }
    first = simplices->rowEnds[k];
    try {
      const FacetRef facet = mesh.facet(v[0], v[1], v[2]);
      if (!c.facetOnBoundary(facet.index())) fail(place, "is not on the boundary");
      // The stored facet points out of the first of its cells.
      const double outward = c.facetCells[facet.index()][0].exists() ? 1 : -1;
      if (!result.emplace(facet.index(), facet.sign() * outward * (*values)[k]).second) {
        fail(place, "is listed twice");
      }
    } catch (const InputError& e) {
      throw e.file().empty() ? InputError(path, place, e.reason()) : e;
    }
  }
  return result;
}

}  // namespace octet
