// SPDX-License-Identifier: Apache-2.0
// Refinement agrees entry by entry with an implementation of SCHEME.md independent of this
// one. The data were written by it: control assets with random coefficients of all degrees
// (*.octet), and per number of levels and boundary mode the refined positions and values (every
// `stride`-th of them) and FNV-1a checksums of the fine edges, facets, tetrahedra and octahedra.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include <gtest/gtest.h>
#include <unistd.h>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/test_data.h"

namespace octet {
namespace {

namespace fs = std::filesystem;

constexpr double kAgreement = 1e-12;

class Checksum {
 public:
  void add(Index x) {
    for (int byte = 0; byte < 4; ++byte) {
      hash_ = (hash_ ^ (static_cast<std::uint32_t>(x) >> (8 * byte) & 0xff)) * 0x100000001b3ull;
    }
  }
  template <typename Rows>
  static std::string of(const Rows& rows) {
    Checksum sum;
    for (const auto& row : rows) {
      for (const Index x : row) sum.add(x);
    }
    return std::to_string(sum.hash_);
  }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

/// A refined complex and forms on it: what the reference's data are compared with.
struct Refined {
  std::array<std::string, 4> checksums;  ///< of edges, facets, tetrahedra, octahedra
  std::vector<Vec3> positions;
  std::map<std::string, std::vector<double>> forms;
};

template <int K>
std::vector<double> refined(const ControlAsset& asset, const Refiner& refiner, const Form& form,
                            BoundaryMode mode) {
  const auto fine = refiner.refine(coefficients<K>(asset, form), mode);
  return {fine.values().begin(), fine.values().end()};
}

Refined refineWithLibrary(const std::string& control, int levels, const std::string& boundary) {
  const ControlAsset asset = readControlAsset(control);
  RefinerOptions options;
  options.levels = levels;
  options.boundaryRows = BoundaryRows::Loop;  // the reference knows no other surface
  const Refiner refiner(asset.mesh, options);
  const Complex& fine = refiner.finest();
  const BoundaryMode mode = boundary == "walls" ? BoundaryMode::Walls : BoundaryMode::Open;
  std::vector<std::array<Index, 3>> facets;
  for (Index f = 0; f < fine.facetCount(); ++f) facets.push_back(fine.facetVertices(f));
  Refined result;
  result.checksums = {Checksum::of(fine.edges), Checksum::of(facets), Checksum::of(fine.tets),
                      Checksum::of(fine.octs)};
  const auto& positions = refiner.positions(levels);
  result.positions.assign(positions.begin(), positions.end());
  for (const Form& form : asset.forms) {
    result.forms[form.name] = form.degree == 0   ? refined<0>(asset, refiner, form, mode)
                              : form.degree == 1 ? refined<1>(asset, refiner, form, mode)
                              : form.degree == 2 ? refined<2>(asset, refiner, form, mode)
                                                 : refined<3>(asset, refiner, form, mode);
  }
  return result;
}

/// Runs `octetvdb refine` and reads the document that it writes.
Refined refineWithCommand(const std::string& control, int levels, const std::string& boundary,
                          const std::string& extension) {
  const std::string out =
      ::testing::TempDir() + "refined." + std::to_string(::getpid()) + extension;
  const std::string command = "\"" OCTETVDB_COMMAND "\" refine \"" + control + "\" --levels " +
                              std::to_string(levels) + " --wall-surface loop --boundary " +
                              boundary + " -o \"" + out + "\"";
  if (std::system(command.c_str()) != 0) throw std::runtime_error("failed: " + command);
  std::ifstream file(out, std::ios::binary);
  const auto document =
      extension == ".cbor" ? nlohmann::json::from_cbor(file) : nlohmann::json::parse(file);
  fs::remove(out);
  const auto checksum = [&](const char* key) {
    return Checksum::of(document.at(key).get<std::vector<std::vector<Index>>>());
  };
  Refined result;
  result.checksums = {checksum("edges"), checksum("facets"), checksum("tetrahedra"),
                      checksum("octahedra")};
  for (const auto& p : document.at("vertices")) result.positions.emplace_back(p[0], p[1], p[2]);
  for (const auto& [name, form] : document.at("forms").items()) {
    result.forms[name] = form.at("values").get<std::vector<double>>();
  }
  return result;
}

nlohmann::json readReference(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return nlohmann::json::from_cbor(file);
}

std::string controlOf(const fs::path& path) {
  const std::string name = path.filename().string();
  return (path.parent_path() / (name.substr(0, name.find('.')) + ".octet")).string();
}

void expectAgreement(const Refined& ours, const nlohmann::json& reference) {
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(ours.checksums[k], reference.at("checksums")[k]);
  }
  const std::size_t stride = reference.at("stride");
  const auto& positions = reference.at("vertices");
  ASSERT_EQ(positions.size(), 3 * ((ours.positions.size() + stride - 1) / stride));
  double size = 0;
  for (const Vec3& p : ours.positions) size = std::max(size, p.lpNorm<Eigen::Infinity>());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const Vec3& p = ours.positions[k / 3 * stride];
    ASSERT_NEAR(p[static_cast<int>(k % 3)], positions[k].get<double>(), kAgreement * size);
  }
  ASSERT_EQ(ours.forms.size(), reference.at("forms").size());
  for (const auto& [name, form] : reference.at("forms").items()) {
    SCOPED_TRACE(name);
    const std::vector<double>& values = ours.forms.at(name);
    const auto& wanted = form.at("values");
    ASSERT_EQ(wanted.size(), (values.size() + stride - 1) / stride);
    const double tolerance = kAgreement * form.at("max").get<double>();
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      ASSERT_NEAR(values[k * stride], wanted[k].get<double>(), tolerance) << "entry " << k * stride;
    }
  }
}

class Reference : public ::testing::TestWithParam<std::string> {};

TEST_P(Reference, AgreesEntryByEntry) {
  const auto reference = readReference(GetParam());
  expectAgreement(
      refineWithLibrary(controlOf(GetParam()), reference.at("levels"), reference.at("boundary")),
      reference);
}

#ifdef OCTETVDB_COMMAND
TEST_P(Reference, AgreesThroughTheCommand) {
  const auto reference = readReference(GetParam());
  for (const char* extension : {".json", ".cbor"}) {
    SCOPED_TRACE(extension);
    expectAgreement(refineWithCommand(controlOf(GetParam()), reference.at("levels"),
                                      reference.at("boundary"), extension),
                    reference);
  }
}
#endif

std::vector<std::string> files() {
  std::vector<std::string> list;
  for (const auto& entry : fs::directory_iterator(testing::testData("reference"))) {
    if (entry.path().extension() == ".cbor") list.push_back(entry.path().string());
  }
  std::sort(list.begin(), list.end());
  return list;
}

INSTANTIATE_TEST_SUITE_P(Files, Reference, ::testing::ValuesIn(files()), [](const auto& mesh) {
  std::string name = fs::path(mesh.param).stem().string();
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
});

TEST(ReferenceData, HoldsEveryKindOfMeshLevelModeAndDegree) {
  for (const char* mesh : {"tetrahedron", "octahedron", "five_tetrahedra", "ball", "creased_cube",
                           "mixed", "lattice_block", "lattice_with_holes", "one_ring"}) {
    const fs::path base = fs::path(testing::testData("reference")) / mesh;
    const ControlAsset asset = readControlAsset(base.string() + ".octet");
    std::set<int> degrees;
    for (const Form& form : asset.forms) {
      const auto all = static_cast<std::size_t>(asset.mesh.complex()->count(form.degree));
      if (form.values.size() == all) degrees.insert(form.degree);
    }
    EXPECT_EQ(degrees, (std::set<int>{0, 1, 2, 3})) << mesh << ": forms with values everywhere";
    for (const int levels : {1, 2}) {
      for (const std::string boundary : {"walls", "open"}) {
        const auto reference =
            readReference(base.string() + "." + std::to_string(levels) + "." + boundary + ".cbor");
        EXPECT_EQ(reference.at("levels"), levels);
        EXPECT_EQ(reference.at("boundary"), boundary);
        EXPECT_EQ(reference.at("forms").size(), asset.forms.size());
      }
    }
  }
}

}  // namespace
}  // namespace octet
