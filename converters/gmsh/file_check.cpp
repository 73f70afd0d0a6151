// SPDX-License-Identifier: Apache-2.0
#include "file_check.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

#include <octet/core/base/error.h>

namespace octet::gmsh_import {
namespace {

using Number = unsigned long long;

/// Takes a number off the front of a text, whatever the locale; false when there is none.
template <typename T>
bool takeNumber(std::string_view* text, T* value) {
  const std::size_t start = text->find_first_not_of(" \t");
  if (start == std::string_view::npos) return false;
  text->remove_prefix(start);
  if (text->front() == '+') text->remove_prefix(1);
  const char* const last = text->data() + text->size();
  const auto [end, error] = std::from_chars(text->data(), last, *value);
  if (error != std::errc() || (end != last && *end != ' ' && *end != '\t')) return false;
  text->remove_prefix(static_cast<std::size_t>(end - text->data()));
  return true;
}

bool startsWith(const std::string& text, const char* start) { return text.rfind(start, 0) == 0; }

/// The lines of a file, counted from 1; line ends of all systems are taken off.
class Lines {
 public:
  explicit Lines(const std::string& path) : in_(path, std::ios::binary) {
    if (!in_) throw InputError("", std::string("cannot be read: ") + std::strerror(errno));
  }

  bool next() {
    if (!std::getline(in_, text_)) return false;
    ++number_;
    cut_ = in_.eof();
    while (!text_.empty() && std::isspace(static_cast<unsigned char>(text_.back()))) {
      text_.pop_back();
    }
    return true;
  }
  /// The next line that is not blank.
  bool nextFilled() {
    while (next()) {
      if (!text_.empty()) return true;
    }
    return false;
  }

  const std::string& text() const { return text_; }
  /// Whether the file ended before the line did.
  bool cut() const { return cut_; }
  std::string place() const { return "line " + std::to_string(number_); }

  std::vector<std::string> words() const {
    std::istringstream in(text_);
    std::vector<std::string> list;
    for (std::string word; in >> word;) list.push_back(word);
    return list;
  }
  /// The line's numbers up to the first word that is none.
  template <typename T>
  std::vector<T> numbers() const {
    std::string_view rest = text_;
    std::vector<T> list;
    for (T value{}; takeNumber(&rest, &value);) list.push_back(value);
    return list;
  }

 private:
  std::ifstream in_;
  std::string text_;
  std::uint64_t number_ = 0;
  bool cut_ = false;
};

/// Walks through the sections of a .msh file. In a binary one only the lines that are text there
/// too are looked at.
class MshCheck {
 public:
  MshCheck(Lines* in, MeshFile* file) : in_(*in), file_(*file) {}

  void run() {
    // Gmsh decides by these words; all else it takes for a script and runs it.
    if (!in_.next() ||
        (!startsWith(in_.text(), "$MeshFormat") && !startsWith(in_.text(), "$Comments"))) {
      throw InputError("line 1", "does not begin with $MeshFormat, as meshes of Gmsh do");
    }
    do {
      line();
    } while (in_.next());
    if (version_ == 0) throw InputError("", "has no $MeshFormat");
    const bool whole = binary_ ? last_.find("$End") != std::string::npos : section_.empty();
    if (!whole) {
      throw InputError(in_.place(),
                       "the file ends before " +
                           (section_.empty() ? "the end of a section" : "$End" + section_) +
                           ": it is cut off");
    }
  }

 private:
  void line() {
    const std::string& text = in_.text();
    if (!text.empty()) last_ = text;
    if (startsWith(text, "$End")) {
      endSection(text.substr(4));
    } else if (startsWith(text, "$") && section_ != "Comments") {
      beginSection(text.substr(1));
    } else if (!text.empty() && !section_.empty()) {
      ++rows_;
    }
  }

  void beginSection(std::string name) {
    if (!section_.empty() && !binary_) {
      throw InputError(in_.place(), "$" + name + " begins before $End" + section_);
    }
    section_ = std::move(name);
    rows_ = 0;
    limit_.reset();
    if (section_ == "MeshFormat") return meshFormat();
    if (section_ == "Nodes" || section_ == "Elements") return meshSection();
    if (section_ == "NodeData" || section_ == "ElementData" || section_ == "ElementNodeData") {
      dataSection();
    }
  }

  void endSection(const std::string& name) {
    if (!binary_ && name != section_) {
      throw InputError(in_.place(), "$End" + name + " ends no section");
    }
    if (!binary_ && limit_ && rows_ > *limit_) {
      throw InputError(in_.place(), "$" + section_ + " has more rows than the number it gives");
    }
    section_.clear();
  }

  void next() {
    if (!in_.next()) throw InputError("", "the file ends in the head of $" + section_);
  }

  void meshFormat() {
    next();
    const auto numbers = in_.numbers<double>();
    if (numbers.size() < 2) {
      throw InputError(in_.place(), "\"" + in_.text() + "\" is no version and format");
    }
    version_ = numbers[0];
    binary_ = numbers[1] != 0;
    if (!(version_ >= 2 && version_ < 5)) {
      throw InputError(in_.place(), "version " + in_.words()[0] + " is none that can be read");
    }
  }

  void meshSection() {
    // Gmsh stops reading the mesh where data begins.
    if (!kinds_.empty()) throw InputError(in_.place(), "$" + section_ + " comes after data");
    if (binary_ && version_ >= 4) return;  // the numbers are binary
    next();
    const bool nodes = section_ == "Nodes";
    const auto numbers = in_.numbers<Number>();
    const std::size_t total = version_ < 4 ? 0 : 1;
    if (numbers.size() <= total) return;
    if (!nodes) file_.elements = numbers[total];
    // One row each; version 4 has a row before each block, and 4.1 gives nodes a row for the number
    // and one for the place.
    limit_ = version_ < 4 ? numbers[0] : numbers[0] + numbers[1] * (nodes ? 2 : 1);
  }

  /// Three lists with their lengths: texts, real numbers, whole numbers.
  void dataSection() {
    std::string name;
    std::vector<int> numbers;
    for (int list = 0; list < 3; ++list) {
      next();
      const auto n = in_.numbers<Number>();
      if (n.empty()) {
        throw InputError(in_.place(), "is not the number of tags that $" + section_ + " needs");
      }
      for (Number k = 0; k < n[0]; ++k) {
        next();
        if (list == 0 && k == 0) name = in_.text();
        if (list != 2) continue;
        const auto tag = in_.numbers<int>();
        if (tag.empty()) throw InputError(in_.place(), "is not a whole number");
        numbers.push_back(tag[0]);
      }
    }
    name.erase(std::remove(name.begin(), name.end(), '"'), name.end());
    const std::string view = "view \"" + name + "\"";
    if (numbers.size() < 3) {
      throw InputError(view, "lacks the time step, number of components or number of entries");
    }
    if (numbers[0] < 0) throw InputError(view, "time step " + std::to_string(numbers[0]));
    if (numbers[2] < 0) throw InputError(view, "a negative number of entries");
    // Gmsh reads both into one view, as what the first is.
    const auto kind = kinds_.emplace(name, section_).first;
    if (kind->second != section_) {
      throw InputError(view, "has both $" + kind->second + " and $" + section_);
    }
    limit_ = static_cast<Number>(numbers[2]);
  }

  Lines& in_;
  MeshFile& file_;
  double version_ = 0;
  bool binary_ = false;
  std::string section_, last_;
  Number rows_ = 0;
  std::optional<Number> limit_;
  std::map<std::string, std::string> kinds_;  ///< section by the view's name
};

/// Gmsh reads Medit files line by line and does not look whether a line holds what it should, so
/// here is looked.
class MeditCheck {
 public:
  explicit MeditCheck(Lines* in) : in_(*in) {}

  void run() {
    if (!in_.next()) throw InputError("", "is empty");
    auto words = in_.words();
    if (words.empty() || words[0] != "MeshVersionFormatted") {
      throw InputError("line 1", "does not begin with MeshVersionFormatted");
    }
    if (words.size() != 2 || (words[1] != "1" && words[1] != "2")) {
      throw InputError("line 1", "Gmsh needs a version here, 1 or 2");
    }
    while (in_.next()) {
      words = in_.words();
      if (!words.empty() && words[0][0] != '#') keyword(words);
    }
  }

 private:
  void keyword(std::vector<std::string> words) {
    // Numbers at the start of a row; the one that follows is the entity's.
    static const std::map<std::string, std::size_t> kRows = {
        {"Vertices", 3},       {"Edges", 3},      {"EdgesP2", 4},       {"Triangles", 4},
        {"TrianglesP2", 7},    {"Tetrahedra", 5}, {"TetrahedraP2", 11}, {"Hexahedra", 9},
        {"Quadrilaterals", 5}, {"Prisms", 0},     {"Pyramids", 0},      {"Dimension", 0}};
    const auto known = kRows.find(words[0]);
    if (known == kRows.end()) return;
    const std::string& name = known->first;
    if (name == "Dimension" && words.size() == 2) return dimension(words[1]);
    if (words.size() != 1) throw InputError(in_.place(), "Gmsh needs a new line after " + name);
    if (!in_.next()) throw InputError("", "the file ends after " + name);
    if (name == "Dimension") {
      words = in_.words();
      return dimension(words.empty() ? "" : words[0]);
    }
    const auto counts = in_.numbers<int>();
    if (counts.size() != 1 || counts[0] < 0) {
      throw InputError(in_.place(), "is not the number of " + name);
    }
    const int n = counts[0];
    if (known->second > 0) return rows(name, n, known->second);
    // Gmsh would leave them out without a word.
    if (n > 0) {
      std::string kind = name;
      kind[0] = static_cast<char>(std::tolower(kind[0]));
      throw InputError("",
                       "has " + std::to_string(n) + " " + kind + "; only tetrahedra can be used");
    }
  }

  void dimension(const std::string& text) const {
    if (text != "3") throw InputError(in_.place(), "the dimension is not 3");
  }

  void rows(const std::string& name, int count, std::size_t numbers) {
    for (int k = 0; k < count; ++k) {
      if (!in_.next()) {
        throw InputError(in_.place(), "the file ends after " + std::to_string(k) + " of " +
                                          std::to_string(count) + " " + name + ": it is cut off");
      }
      const std::size_t found =
          name == "Vertices" ? in_.numbers<double>().size() : in_.numbers<int>().size();
      // Gmsh reads 255 characters of a line.
      if (found < numbers || in_.text().size() > 250) {
        throw InputError(in_.place(), "does not hold the numbers of one of the " + name);
      }
    }
  }

  Lines& in_;
};

void checkVtk(Lines* in) {
  const auto malformed = [&](const std::string& reason) { throw InputError(in->place(), reason); };
  if (!in->next() || !startsWith(in->text(), "# vtk DataFile Version")) {
    throw InputError("line 1",
                     "does not begin with \"# vtk DataFile Version\": no legacy VTK file");
  }
  // Version 5 came with a single digit before the point; there is none beyond.
  if (in->words().size() < 5 || in->words()[4][0] >= '5') {
    malformed("Gmsh reads legacy VTK files up to version 4.2, which lists cells in another way");
  }
  if (!in->next() || !in->nextFilled()) malformed("the file ends in its head");
  const bool text = in->text() == "ASCII";
  if (!text && in->text() != "BINARY") malformed("is neither ASCII nor BINARY");
  if (!in->nextFilled() ||
      in->words() != std::vector<std::string>{"DATASET", "UNSTRUCTURED_GRID"}) {
    malformed("is not DATASET UNSTRUCTURED_GRID, the one kind with tetrahedra");
  }
  if (!text) return;
  while (in->next()) {
  }
  // A last cell type 10 cut off to 1 would still be one.
  if (in->cut()) malformed("the file ends within a line: it is cut off");
}

MeshFormat formatOf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (extension == ".msh") return MeshFormat::Msh;
  if (extension == ".mesh") return MeshFormat::Medit;
  if (extension == ".vtk") return MeshFormat::Vtk;
  throw InputError("", "is not a .msh, .mesh or .vtk file");
}

}  // namespace

MeshFile checkMeshFile(const std::string& path) {
  MeshFile file;
  file.format = formatOf(path);
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw InputError("", "is not a file");
  Lines in(path);
  file.bytes = std::filesystem::file_size(path, error);
  if (file.bytes == 0) throw InputError("", "is empty");
  if (file.format == MeshFormat::Msh) MshCheck(&in, &file).run();
  if (file.format == MeshFormat::Medit) MeditCheck(&in).run();
  if (file.format == MeshFormat::Vtk) checkVtk(&in);
  return file;
}

}  // namespace octet::gmsh_import
