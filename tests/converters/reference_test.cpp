// SPDX-License-Identifier: Apache-2.0
// Refinement agrees entry by entry with the reference implementation of scheme.md. The data were
// written by it: control assets with random coefficients of all degrees (*.octet), and per number
// of levels and boundary mode the refined positions and values (every `stride`-th of them) and
// FNV-1a checksums of the fine edges, facets, tetrahedra and octahedra.
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include <gtest/gtest.h>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/refine/refiner.h>

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

template <int K>
Array<double> refined(const ControlAsset& asset, const Refiner& refiner, const Form& form,
                      BoundaryMode mode) {
  return refiner.refine(coefficients<K>(asset, form), mode).values();
}

class Reference : public ::testing::TestWithParam<std::string> {};

TEST_P(Reference, AgreesEntryByEntry) {
  const fs::path path = GetParam();
  std::ifstream file(path, std::ios::binary);
  const auto expected = nlohmann::json::from_cbor(file);
  const std::string name = path.filename().string();
  const ControlAsset asset =
      readControlAsset((path.parent_path() / (name.substr(0, name.find('.')) + ".octet")).string());
  RefinerOptions options;
  options.levels = expected.at("levels");
  const Refiner refiner(asset.mesh, options);
  const Complex& fine = refiner.finest();

  std::vector<std::array<Index, 3>> facets;
  for (Index f = 0; f < fine.facetCount(); ++f) facets.push_back(fine.facetVertices(f));
  EXPECT_EQ(Checksum::of(fine.edges), expected.at("checksums")[0]);
  EXPECT_EQ(Checksum::of(facets), expected.at("checksums")[1]);
  EXPECT_EQ(Checksum::of(fine.tets), expected.at("checksums")[2]);
  EXPECT_EQ(Checksum::of(fine.octs), expected.at("checksums")[3]);

  const Index stride = expected.at("stride");
  const auto& positions = expected.at("vertices");
  ASSERT_EQ(positions.size(), 3u * ((fine.vertexCount() + stride - 1) / stride));
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const Vec3& p = refiner.positions(options.levels)[static_cast<Index>(k / 3) * stride];
    ASSERT_NEAR(p[static_cast<int>(k % 3)], positions[k].get<double>(), 10 * kAgreement);
  }
  const BoundaryMode mode =
      expected.at("boundary") == "walls" ? BoundaryMode::Walls : BoundaryMode::Open;
  for (const auto& [formName, reference] : expected.at("forms").items()) {
    SCOPED_TRACE(formName);
    const Form& form = asset.form(formName);
    const Array<double> values = form.degree == 0   ? refined<0>(asset, refiner, form, mode)
                                 : form.degree == 1 ? refined<1>(asset, refiner, form, mode)
                                 : form.degree == 2 ? refined<2>(asset, refiner, form, mode)
                                                    : refined<3>(asset, refiner, form, mode);
    const auto& wanted = reference.at("values");
    ASSERT_EQ(wanted.size(), (values.size() + stride - 1) / stride);
    const double tolerance = kAgreement * reference.at("max").get<double>();
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      ASSERT_NEAR(values[k * static_cast<std::size_t>(stride)], wanted[k].get<double>(), tolerance)
          << "entry " << k * static_cast<std::size_t>(stride);
    }
  }
}

std::vector<std::string> files() {
  std::vector<std::string> list;
  for (const auto& entry : fs::directory_iterator(OCTET_TEST_DATA "/reference")) {
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

TEST(ReferenceData, IsThere) { EXPECT_GE(files().size(), 36u); }

}  // namespace
}  // namespace octet
