// SPDX-License-Identifier: Apache-2.0
#include "gmsh_import.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

#include <octet/core/base/error.h>
#include <octet/core/base/system.h>

#include "file_check.h"
#include "gmsh_program.h"

namespace octet {
namespace {

using namespace gmsh_import;

/// Numbers of Gmsh's element types.
enum Type { kLine = 1, kTriangle = 2, kTetrahedron = 4, kPoint = 15 };

/// The file under a name of ours, for as long as this lives: beside the real one Gmsh would look
/// for a FILE.opt and run it.
class PrivateName {
 public:
  PrivateName(const std::string& file, MeshFormat format)
      : folder_(system::makeTemporaryFolder("octetvdb-")) {
    const char* names[] = {"mesh.msh", "mesh.mesh", "mesh.vtk"};
    path_ = folder_ / names[static_cast<int>(format)];
    std::error_code error;
    std::filesystem::create_symlink(std::filesystem::absolute(file), path_, error);
    if (error) {
      remove();
      throw IoError(path_, "cannot be made: " + error.message());
    }
  }
  ~PrivateName() { remove(); }
  PrivateName(const PrivateName&) = delete;
  PrivateName& operator=(const PrivateName&) = delete;

  std::string path() const { return path_; }

 private:
  void remove() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
    std::filesystem::remove(folder_, ignored);
  }

  std::filesystem::path folder_, path_;
};

GmshMesh readInProgram(const std::string& path, const MeshFile& file) {
  const PrivateName name(path, file.format);
  GmshWork work;
  work.request = MessageKind::ReadMesh;
  work.who = "Gmsh";
  work.doing = "reading it: it is damaged";
  // Generous: reading takes about 30 times the size of the file, and a second per 10 MB.
  work.mostBytes = kLeastMemory + 100 * file.bytes;
  work.time = kLeastTime + std::chrono::milliseconds(file.bytes / 500);
  work.content = pack(MeshRequest{name.path(), work.mostBytes});
  return askGmsh<GmshMesh>(work);
}

/// "hexahedra" for "Hexahedron 8".
std::string plural(const std::string& typeName) {
  std::string kind = typeName.substr(0, typeName.find(' '));
  for (char& c : kind) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::size_t end = kind.size() < 2 ? 0 : kind.size() - 2;
  if (kind.compare(end, 2, "on") == 0) return kind.substr(0, end) + "a";
  return kind + "s";
}

/// Makes the control asset from what Gmsh found.
class AssetBuilder {
 public:
  explicit AssetBuilder(GmshMesh mesh) : in_(std::move(mesh)) {}

  ControlAsset run(const MeshFile& file) {
    checkConsistency(file);
    checkCells();
    numberVertices();
    numberElements();
    asset_.mesh = ControlMesh::build(controlMesh());
    for (const View& view : in_.views) addForm(view);
    return std::move(asset_);
  }

 private:
  struct Element {
    Tag tag;
    const ElementBlock* block;
    const Tag* nodes;
    bool operator<(const Element& other) const { return tag < other.tag; }
  };

  static bool whole(const ElementBlock& b) {
    return b.nodesPerElement > 0 &&
           b.nodes.size() == b.tags.size() * static_cast<std::size_t>(b.nodesPerElement);
  }

  void checkConsistency(const MeshFile& file) const {
    std::uint64_t elements = 0;
    for (const ElementBlock& block : in_.blocks) {
      if (!whole(block)) throw InputError("", "Gmsh failed reading its elements");
      elements += block.tags.size();
    }
    if (in_.coordinates.size() != 3 * in_.nodeTags.size()) {
      throw InputError("", "Gmsh failed reading its nodes");
    }
    // In version 2 the last of those with the same number wins, which a message and the number of
    // elements give away.
    const std::string duplicate = "Skipping duplicate node ";
    for (const std::string& message : in_.messages) {
      const std::size_t found = message.find(duplicate);
      if (found == std::string::npos) continue;
      throw InputError("node " + message.substr(found + duplicate.size()), "is listed twice");
    }
    if (file.elements && *file.elements != elements) {
      throw InputError("$Elements", "declares " + std::to_string(*file.elements) +
                                        " elements but " + std::to_string(elements) +
                                        " of different number can be read");
    }
  }

  void checkCells() const {
    std::string others;
    bool any = false;
    for (const ElementBlock& block : in_.blocks) {
      any |= block.type == kTetrahedron;
      if (block.dimension != 3 || block.type == kTetrahedron) continue;
      others += (others.empty() ? "has " : ", ") + std::to_string(block.tags.size()) + " " +
                plural(block.typeName);
      if (plural(block.typeName) == "tetrahedra") {
        others += " of higher order with " + std::to_string(block.nodesPerElement) + " nodes";
      }
    }
    if (!others.empty()) {
      throw InputError("", others + "; only linear tetrahedra with 4 nodes can be used");
    }
    if (!any) throw InputError("", "has no tetrahedra");
  }

  /// Nodes of tetrahedra, by tag.
  void numberVertices() {
    for (const ElementBlock& block : in_.blocks) {
      if (block.type != kTetrahedron) continue;
      vertexTags_.insert(vertexTags_.end(), block.nodes.begin(), block.nodes.end());
    }
    std::sort(vertexTags_.begin(), vertexTags_.end());
    vertexTags_.erase(std::unique(vertexTags_.begin(), vertexTags_.end()), vertexTags_.end());
    if (vertexTags_.size() > INT32_MAX) throw InputError("", "has too many nodes to be numbered");
  }

  std::optional<Index> vertex(Tag node) const {
    const auto found = std::lower_bound(vertexTags_.begin(), vertexTags_.end(), node);
    if (found == vertexTags_.end() || *found != node) return std::nullopt;
    return static_cast<Index>(found - vertexTags_.begin());
  }

  /// The nodes of an element as vertices; throws when they are none.
  std::vector<Index> vertices(const Element& element, const std::string& place) const {
    std::vector<Index> list;
    for (int k = 0; k < element.block->nodesPerElement; ++k) {
      const auto v = vertex(element.nodes[k]);
      if (!v) {
        throw InputError(place,
                         "node " + std::to_string(element.nodes[k]) + " belongs to no tetrahedron");
      }
      list.push_back(*v);
    }
    return list;
  }

  template <typename Use>
  static void visit(const std::vector<ElementBlock>& blocks, const Use& use) {
    for (const ElementBlock& block : blocks) {
      if (!whole(block)) throw InputError("", "Gmsh failed reading its elements");
      for (std::size_t k = 0; k < block.tags.size(); ++k) {
        use(Element{block.tags[k], &block,
                    &block.nodes[k * static_cast<std::size_t>(block.nodesPerElement)]});
      }
    }
  }

  void numberElements() {
    visit(in_.blocks, [&](const Element& element) { elements_.push_back(element); });
    std::sort(elements_.begin(), elements_.end());
    for (std::size_t k = 1; k < elements_.size(); ++k) {
      if (elements_[k].tag == elements_[k - 1].tag) {
        throw InputError("element " + std::to_string(elements_[k].tag), "is listed twice");
      }
    }
    for (const Element& element : elements_) {
      if (element.block->type == kTetrahedron) cellTags_.push_back(element.tag);
    }
  }

  ControlMeshInput controlMesh() const {
    ControlMeshInput input;
    input.vertices.resize(vertexTags_.size());
    std::vector<bool> placed(vertexTags_.size(), false);
    for (std::size_t k = 0; k < in_.nodeTags.size(); ++k) {
      const auto v = vertex(in_.nodeTags[k]);
      if (!v) continue;
      if (placed[*v]) {
        throw InputError("node " + std::to_string(in_.nodeTags[k]), "is listed twice");
      }
      placed[*v] = true;
      const double* x = &in_.coordinates[3 * k];
      input.vertices[*v] = Vec3(x[0], x[1], x[2]);
    }
    const auto missing = std::find(placed.begin(), placed.end(), false);
    if (missing != placed.end()) {
      throw InputError("node " + std::to_string(vertexTags_[missing - placed.begin()]),
                       "is used by a tetrahedron but not listed");
    }
    for (const Element& element : elements_) {
      if (element.block->type != kTetrahedron) continue;
      const auto v = vertices(element, "");
      input.tets.push_back({v[0], v[1], v[2], v[3]});
    }
    addFeatures(&input);
    return input;
  }

  /// Creases and corners from physical groups.
  void addFeatures(ControlMeshInput* input) const {
    std::set<Index> corners;
    for (const PhysicalGroup& group : in_.groups) {
      std::string name = group.name;
      for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      const bool creases = group.dimension == 1 && (name == "crease" || name == "creases");
      if (!creases && !(group.dimension == 0 && (name == "corner" || name == "corners"))) continue;
      if (creases && !input->creases) input->creases.emplace();
      visit(group.blocks, [&](const Element& element) {
        const std::string place =
            "physical group \"" + group.name + "\", element " + std::to_string(element.tag);
        if (element.block->type != (creases ? kLine : kPoint)) {
          throw InputError(place, "is a " + element.block->typeName + ", not a " +
                                      (creases ? "line with 2 nodes" : "point"));
        }
        const auto v = vertices(element, place);
        if (creases) {
          input->creases->push_back({v[0], v[1]});
        } else {
          corners.insert(v[0]);
        }
      });
    }
    input->corners.assign(corners.begin(), corners.end());
  }

  /// What a view's entry stands for.
  struct Place {
    Index simplex;
    std::int8_t sign;
  };

  const Element& element(Tag tag, const std::string& place) const {
    const auto found = std::lower_bound(elements_.begin(), elements_.end(), Element{tag, {}, {}});
    if (found == elements_.end() || found->tag != tag) {
      throw InputError(place, "the mesh has no such element");
    }
    return *found;
  }

  static int degreeOf(const Element& element, const std::string& place) {
    switch (element.block->type) {
      case kLine:
        return 1;
      case kTriangle:
        return 2;
      case kTetrahedron:
        return 3;
      default:
        throw InputError(place, "is a " + element.block->typeName +
                                    "; data belongs on lines with 2 nodes, triangles with 3 or "
                                    "tetrahedra with 4");
    }
  }

  Place placeOf(const Element& element, const std::string& place) const {
    if (element.block->type == kTetrahedron) {
      const auto cell = std::lower_bound(cellTags_.begin(), cellTags_.end(), element.tag);
      return {static_cast<Index>(cell - cellTags_.begin()), 1};
    }
    const auto v = vertices(element, place);
    const bool line = element.block->type == kLine;
    try {
      if (line) {
        const EdgeRef e = asset_.mesh.edge(v[0], v[1]);
        return {e.index(), static_cast<std::int8_t>(e.reversed() ? -1 : 1)};
      }
      const FacetRef f = asset_.mesh.facet(v[0], v[1], v[2]);
      return {f.index(), static_cast<std::int8_t>(f.sign() < 0 ? -1 : 1)};
    } catch (const InputError&) {
      throw InputError(place, line ? "its nodes are not an edge of the tetrahedra"
                                   : "its nodes are not a facet of the tetrahedra");
    }
  }

  /// Collects a view's entries over its time steps; lists each simplex once.
  class FormBuilder {
   public:
    FormBuilder(const AssetBuilder& asset, const View& view)
        : asset_(asset), view_(view), nodes_(view.dataType == "NodeData") {}

    Form run() {
      form_.name = view_.name;
      if (nodes_) form_.degree = 0;
      for (const ViewStep& step : view_.steps) addEntries(step);
      for (const ViewStep& step : view_.steps) addValues(step);
      return std::move(form_);
    }

   private:
    std::string place(Tag tag) const {
      return "view \"" + view_.name + "\", " + (nodes_ ? "node " : "element ") +
             std::to_string(tag);
    }

    void addEntries(const ViewStep& step) {
      for (const Tag tag : step.tags) {
        if (rows_.count(tag)) continue;
        if (nodes_) {
          if (const auto v = asset_.vertex(tag)) add(tag, {*v, 1});
          continue;
        }
        const std::string where = place(tag);
        const Element& element = asset_.element(tag, where);
        const int degree = degreeOf(element, where);
        if (!rows_.empty() && degree != form_.degree) {
          throw InputError(where, "is a " + element.block->typeName + " among " +
                                      plural(typeName_) + "; a form has one degree");
        }
        form_.degree = degree;
        typeName_ = element.block->typeName;
        add(tag, asset_.placeOf(element, where));
      }
    }

    void add(Tag tag, const Place& at) {
      const auto [other, fresh] = tags_.emplace(at.simplex, tag);
      if (!fresh) {
        throw InputError(place(tag),
                         "has the same nodes as element " + std::to_string(other->second));
      }
      rows_.emplace(tag, form_.simplices.size());
      form_.simplices.push_back(at.simplex);
      form_.signs.push_back(at.sign);
    }

    void addValues(const ViewStep& step) {
      std::vector<double> values(form_.simplices.size(), 0.0);
      for (std::size_t k = 0; k < step.tags.size(); ++k) {
        if (!std::isfinite(step.values[k])) {
          throw InputError(place(step.tags[k]), "is not a finite number");
        }
        const auto row = rows_.find(step.tags[k]);
        if (row != rows_.end()) values[row->second] = step.values[k];
      }
      if (view_.steps.size() == 1) {
        form_.values = std::move(values);
      } else {
        form_.frames[step.step] = std::move(values);
      }
    }

    const AssetBuilder& asset_;
    const View& view_;
    const bool nodes_;
    Form form_;
    std::string typeName_;
    std::map<Tag, std::size_t> rows_;  ///< place in the form, by node or element
    std::map<Index, Tag> tags_;        ///< node or element, by simplex
  };

  void addForm(const View& view) {
    if (view.steps.empty()) return;
    const std::string place = "view \"" + view.name + "\"";
    if (view.name.empty()) throw InputError(place, "has no name");
    if (view.dataType != "NodeData" && view.dataType != "ElementData") {
      throw InputError(place, "holds " + view.dataType + "; a form needs one number per node (" +
                                  "NodeData) or element (ElementData)");
    }
    for (const ViewStep& step : view.steps) {
      if (step.components != 1 || step.values.size() != step.tags.size()) {
        throw InputError(place, "has " + std::to_string(step.components) +
                                    " components; a form's coefficients are single numbers");
      }
    }
    for (const Form& form : asset_.forms) {
      if (form.name == view.name) throw InputError(place, "has the same time step twice");
    }
    asset_.forms.push_back(FormBuilder(*this, view).run());
  }

  const GmshMesh in_;
  ControlAsset asset_;
  std::vector<Tag> vertexTags_;    ///< by vertex, ascending
  std::vector<Tag> cellTags_;      ///< by cell, ascending
  std::vector<Element> elements_;  ///< all, by tag
};

}  // namespace

ControlAsset readGmshMesh(const std::string& path) {
  try {
    const MeshFile file = checkMeshFile(path);
    ControlAsset asset = AssetBuilder(readInProgram(path, file)).run(file);
    asset.name = std::filesystem::path(path).stem().string();
    return asset;
  } catch (const InputError& e) {
    throw e.inFile(path);
  }
}

}  // namespace octet
