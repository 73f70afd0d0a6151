// SPDX-License-Identifier: Apache-2.0
// Rules at irregular interior stars (core/SCHEME.md sections 6b and 6c): their tables and closed
// forms, and whole steps, are compared with the reference's (tests/data/oracle); what they must
// keep on any mesh is checked on random ones.
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include <gtest/gtest.h>

#include <octet/core/forms/coboundary.h>
#include <octet/core/refine/flux_stars.h>
#include <octet/core/refine/interior_moves.h>
#include <octet/core/refine/refiner.h>
#include <octet/core/rules/interior_rules.h>
#include <octet/core/rules/star_fluxes.h>

#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace octet {
namespace {

nlohmann::json readOracle(const std::string& name) {
  std::ifstream file(testing::testData("oracle/" + name));
  return nlohmann::json::parse(file);
}

Refiner refined(const ControlMeshInput& input, int levels) {
  RefinerOptions options;
  options.levels = levels;
  options.boundaryRows = BoundaryRows::Loop;
  return Refiner(ControlMesh::build(input), options);
}

// ---- tables and closed forms -------------------------------------------------------------------

TEST(LineMoves, AreThoseOfTheReference) {
  const auto valences = readOracle("x2_rules.json").at("valences");
  for (int n = 3; n <= 12; ++n) {
    const LineMoves moves = lineMoves(n);
    const auto& wanted = valences.at(std::to_string(n));
    for (int j = 0; j < n; ++j) {
      const auto k = static_cast<std::size_t>(j);
      EXPECT_NEAR(moves.ring[k], wanted.at("kappa")[k].get<double>(), 1e-14) << n << " " << j;
      EXPECT_NEAR(moves.beyond[k], wanted.at("omega")[k].get<double>(), 1e-14) << n << " " << j;
    }
  }
}

/// The label of a name such as r3 in the pattern at a line of n tetrahedra.
int lineLabel(const std::string& name, int n) {
  if (name == "m") return 0;
  if (name == "a" || name == "b") return name == "a" ? 1 : 2;
  const int group = name[0] == 'r' ? 0 : name[0] == 's' ? 1 : 2;
  return 3 + group * n + std::stoi(name.substr(1));
}

/// A pattern as (edge, facet) -> weight, labels ascending and the orders' signs in the weight.
using Weights = std::map<std::pair<std::vector<int>, std::vector<int>>, double>;

double sortedSign(std::vector<int>* labels) {
  double sign = 1;
  for (std::size_t i = 0; i < labels->size(); ++i) {
    for (std::size_t j = i + 1; j < labels->size(); ++j) {
      if ((*labels)[i] > (*labels)[j]) sign = -sign;
    }
  }
  std::sort(labels->begin(), labels->end());
  return sign;
}

Weights weightsOf(const FluxPattern& pattern) {
  Weights result;
  for (const auto& term : pattern.terms) {
    std::vector<int> edge(pattern.edges[term.edge].begin(), pattern.edges[term.edge].end());
    std::vector<int> facet(pattern.facets[term.facet].begin(), pattern.facets[term.facet].end());
    const double sign = sortedSign(&edge) * sortedSign(&facet);
    result[{edge, facet}] += sign * term.weight;
  }
  return result;
}

void expectSame(const Weights& ours, const Weights& wanted) {
  EXPECT_EQ(ours.size(), wanted.size());
  for (const auto& [pair, weight] : wanted) {
    const auto found = ours.find(pair);
    ASSERT_NE(found, ours.end());
    EXPECT_NEAR(found->second, weight, 1e-15);
  }
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

TEST(LineFluxes, HaveTheReferencesImages) {
  const auto example = readOracle("x2_rules.json").at("example_images");
  const int n = example.at("n");
  Weights wanted;
  for (const auto& pair : example.at("pairs")) {
    std::vector<int> edge, facet;
    for (const auto& w : words(pair[0])) edge.push_back(lineLabel(w, n));
    for (const auto& w : words(pair[1])) facet.push_back(lineLabel(w, n));
    const double sign = sortedSign(&edge) * sortedSign(&facet);
    wanted[{edge, facet}] += sign * pair[2].get<double>() * 1e-6;
  }
  expectSame(weightsOf(lineFluxes(n)), wanted);
}

TEST(LineFluxes, HaveTheReferencesWeights) {
  const auto oracle = readOracle("x2_rules.json");
  for (int n = 3; n <= 12; ++n) {
    const Weights ours = weightsOf(lineFluxes(n));
    EXPECT_EQ(lineFluxes(n).terms.size(),
              oracle.at("valences").at(std::to_string(n)).at("images").get<std::size_t>());
    for (const auto& row : oracle.at("rows")) {
      std::vector<int> edge, facet;
      for (const auto& w : row.at("edge")) edge.push_back(lineLabel(w, n));
      for (const auto& w : row.at("facet")) facet.push_back(lineLabel(w, n));
      const double sign = sortedSign(&edge) * sortedSign(&facet);
      const double weight = row.at("millionths").at(std::to_string(n)).get<double>() * 1e-6;
      const auto found = ours.find({edge, facet});
      ASSERT_NE(found, ours.end());
      EXPECT_NEAR(found->second, sign * weight, 1e-15);
    }
  }
  EXPECT_TRUE(lineFluxes(2).terms.empty());
  EXPECT_TRUE(lineFluxes(13).terms.empty());
}

TEST(TwinFluxes, HaveTheReferencesWeights) {
  const auto label = [](const std::string& name) {
    const std::map<char, int> first{{'r', 1}, {'u', 7}, {'w', 10}, {'p', 13}, {'q', 16}};
    return name == "m" ? 0 : first.at(name[0]) + std::stoi(name.substr(1));
  };
  const Weights ours = weightsOf(twinFluxes());
  std::size_t images = 0;
  const auto oracle = readOracle("x1_rules.json");
  for (const auto& row : oracle.at("rows")) {
    std::vector<int> edge, facet;
    for (const auto& w : words(row.at("edge"))) edge.push_back(label(w));
    for (const auto& w : words(row.at("facet"))) facet.push_back(label(w));
    const double sign = sortedSign(&edge) * sortedSign(&facet);
    const auto found = ours.find({edge, facet});
    ASSERT_NE(found, ours.end());
    EXPECT_NEAR(found->second, sign * row.at("weight").get<double>(), 1e-15);
    images += row.at("images").get<std::size_t>();
  }
  EXPECT_EQ(twinFluxes().terms.size(), images);
}

// ---- whole steps -------------------------------------------------------------------------------

template <typename Simplex>
std::vector<Simplex> simplices(const nlohmann::json& list) {
  return list.get<std::vector<Simplex>>();
}

struct Case {
  ControlMesh mesh;
  nlohmann::json asset;
};

Case readCase(const nlohmann::json& asset) {
  ControlMeshInput input;
  for (const auto& p : asset.at("vertices")) input.vertices.emplace_back(p[0], p[1], p[2]);
  for (const auto& t : simplices<std::array<Index, 4>>(asset.at("tetrahedra"))) {
    input.tets.push_back(t);
  }
  for (const auto& o : simplices<std::array<Index, 6>>(asset.at("octahedra"))) {
    input.octs.push_back(o);
  }
  input.creases.emplace();
  for (const auto& e : simplices<std::array<Index, 2>>(asset.at("creases"))) {
    input.creases->push_back(e);
  }
  for (const Index v : asset.at("corners")) input.corners.push_back(v);
  return {ControlMesh::build(std::move(input)), asset};
}

/// Control coefficients of a form of a case.
template <int K>
Cochain<K> coefficients(const Case& from, const nlohmann::json& form) {
  const Complex& c = *from.mesh.complex();
  Cochain<K> result(c);
  const auto lists = simplices<std::vector<Index>>(form.at("simplices"));
  for (std::size_t k = 0; k < lists.size(); ++k) {
    const std::vector<Index>& v = lists[k];
    const double value = form.at("values")[k];
    if constexpr (K == 0) {
      result[v[0]] = value;
    } else if constexpr (K == 1) {
      const EdgeRef e = from.mesh.edge(v[0], v[1]);
      result[e.index()] = e.sign() * value;
    } else if constexpr (K == 2) {
      const FacetRef f = from.mesh.facet(v[0], v[1], v[2]);
      result[f.index()] = f.sign() * value;
    } else {
      for (Index cell = 0; cell < c.cellCount(); ++cell) {
        bool same = c.cellVertexCount(cell) == static_cast<int>(v.size());
        for (std::size_t i = 0; same && i < v.size(); ++i) {
          same = c.cellVertex(cell, static_cast<int>(i)) == v[i];
        }
        if (same) result[cell] = value;
      }
    }
  }
  return result;
}

template <int K>
void expectForm(const Case& from, const Refiner& refiner, const nlohmann::json& form,
                const nlohmann::json& wanted, BoundaryMode mode) {
  const Cochain<K> fine = refiner.refine(coefficients<K>(from, form), mode);
  ASSERT_EQ(static_cast<std::size_t>(fine.size()), wanted.size());
  for (Index k = 0; k < fine.size(); ++k) {
    ASSERT_NEAR(fine[k], wanted[static_cast<std::size_t>(k)].get<double>(), 1e-11)
        << "degree " << K << " entry " << k;
  }
}

TEST(IrregularSteps, AgreeEntryByEntryWithTheReference) {
  const auto oracle = readOracle("irregular_steps.json");
  for (const auto& one : oracle.at("cases")) {
    SCOPED_TRACE(one.at("name").get<std::string>());
    const Case from = readCase(one.at("asset"));
    RefinerOptions options;
    options.levels = one.at("levels");
    options.boundaryRows = BoundaryRows::Loop;  // the reference knows no other surface
    const Refiner refiner(from.mesh, options);
    const auto& wanted = one.at("vertices");
    ASSERT_EQ(wanted.size(), refiner.positions(options.levels).size());
    for (std::size_t v = 0; v < wanted.size(); ++v) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        ASSERT_NEAR(refiner.positions(options.levels)[v][static_cast<int>(axis)],
                    wanted[v][axis].get<double>(), 1e-11)
            << "vertex " << v;
      }
    }
    for (const auto& [name, mode] :
         {std::pair{"walls", BoundaryMode::Walls}, std::pair{"open", BoundaryMode::Open}}) {
      SCOPED_TRACE(name);
      for (const auto& form : one.at("asset").at("forms")) {
        const auto& values = one.at(name).at(form.at("name").get<std::string>());
        switch (form.at("degree").get<int>()) {
          case 0:
            expectForm<0>(from, refiner, form, values, mode);
            break;
          case 1:
            expectForm<1>(from, refiner, form, values, mode);
            break;
          case 2:
            expectForm<2>(from, refiner, form, values, mode);
            break;
          default:
            expectForm<3>(from, refiner, form, values, mode);
        }
      }
    }
  }
}

// ---- on random meshes --------------------------------------------------------------------------

TEST(InteriorMoves, LeaveConstantsAlone) {
  std::size_t rows = 0;
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const Refiner refiner = refined(testing::withOctahedra(testing::randomBall(70, seed)), 2);
    Cochain<0> one(refiner.complex(0));
    for (Index v = 0; v < one.size(); ++v) one[v] = 1;
    const Cochain<0> fine = refiner.refine(one, BoundaryMode::Open);
    for (Index v = 0; v < fine.size(); ++v) ASSERT_NEAR(fine[v], 1, 1e-13);
    for (const StarMoves& star : interiorMoves(IrregularStars(refiner.complex(1)))) {
      rows += star.terms.size();
    }
  }
  EXPECT_GT(rows, 1000u);
}

/// The fine vertices of one mesh as those of the same mesh numbered otherwise: the nearest.
std::vector<Index> sameVertices(const Array<Vec3>& a, const Array<Vec3>& b) {
  std::vector<Index> order(b.size());
  for (std::size_t k = 0; k < b.size(); ++k) order[k] = static_cast<Index>(k);
  std::sort(order.begin(), order.end(), [&](Index i, Index j) { return b[i][0] < b[j][0]; });
  constexpr double kSame = 1e-9;
  std::vector<Index> result(a.size(), kNone);
  for (std::size_t k = 0; k < a.size(); ++k) {
    auto at = std::lower_bound(order.begin(), order.end(), a[k][0] - kSame,
                               [&](Index i, double x) { return b[i][0] < x; });
    for (; at != order.end() && b[*at][0] < a[k][0] + kSame; ++at) {
      if ((b[*at] - a[k]).norm() < kSame) result[k] = *at;
    }
  }
  return result;
}

/// A flux that knows nothing of numbers: an odd function of the corners' order.
double fluxThrough(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 middle = (a + b + c) / 3;
  const Vec3 field(std::sin(3 * middle[1]), std::cos(2 * middle[2]), middle[0] * middle[1]);
  return field.dot((b - a).cross(c - a)) / 2;
}

Cochain<2> fluxes(const Refiner& refiner) {
  const Complex& c = refiner.complex(0);
  Cochain<2> result(c);
  const auto& x = refiner.positions(0);
  for (Index f = 0; f < c.facetCount(); ++f) {
    const auto v = c.facetVertices(f);
    result[f] = fluxThrough(x[v[0]], x[v[1]], x[v[2]]);
  }
  return result;
}

/// Facets by their sorted vertices: the coefficient as seen from that order.
std::map<std::array<Index, 3>, double> byVertices(const Complex& c, const Cochain<2>& form,
                                                  const std::vector<Index>& name) {
  std::map<std::array<Index, 3>, double> result;
  for (Index f = 0; f < c.facetCount(); ++f) {
    auto v = c.facetVertices(f);
    for (Index& x : v) x = name[static_cast<std::size_t>(x)];
    double sign = 1;
    for (int i = 0; i < 3; ++i) {
      for (int j = i + 1; j < 3; ++j) {
        if (v[i] > v[j]) sign = -sign;
      }
    }
    std::sort(v.begin(), v.end());
    result[v] = sign * form[f];
  }
  return result;
}

TEST(IrregularStars, DoNotDependOnTheNumbering) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    ControlMeshInput mesh = testing::randomBall(60, seed);
    if (seed % 2 == 0) mesh = testing::withOctahedra(std::move(mesh));
    const Refiner ours = refined(mesh, 2), other = refined(testing::shuffled(mesh, seed + 7), 2);
    const std::vector<Index> name = sameVertices(ours.positions(2), other.positions(2));
    ASSERT_EQ(std::count(name.begin(), name.end(), kNone), 0) << "positions differ";
    std::vector<Index> own(other.positions(2).size());
    for (std::size_t k = 0; k < own.size(); ++k) own[k] = static_cast<Index>(k);
    const auto a = byVertices(ours.finest(), ours.refine(fluxes(ours), BoundaryMode::Open), name);
    const auto b = byVertices(other.finest(), other.refine(fluxes(other), BoundaryMode::Open), own);
    ASSERT_EQ(a.size(), b.size());
    double most = 0;
    for (const auto& [vertices, value] : a) most = std::max(most, std::abs(value));
    for (const auto& [vertices, value] : a) {
      ASSERT_NEAR(value, b.at(vertices), 1e-11 * most);
    }
  }
}

/// Equal stars give the same numbers, whatever the numbering: only sums over stars round.
TEST(IrregularStars, SolveEqualStarsAlike) {
  const auto weights = [](const ControlMeshInput& mesh) {
    const Refiner refiner = refined(mesh, 1);
    std::vector<double> list;
    for (const StarMoves& star : interiorMoves(IrregularStars(refiner.complex(1)))) {
      for (const auto& term : star.terms) list.push_back(std::abs(term.weight));
    }
    std::sort(list.begin(), list.end());
    return list;
  };
  const ControlMeshInput mesh = testing::withOctahedra(testing::randomBall(80, 3));
  const auto first = weights(mesh);
  EXPECT_GT(first.size(), 100u);
  const auto second = weights(testing::shuffled(mesh, 5));
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t k = 0; k < first.size(); ++k) ASSERT_NEAR(first[k], second[k], 1e-15);
}

TEST(IrregularStars, ClaimNoFineEdgeTwice) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const Refiner refiner = refined(testing::randomBall(70, seed), 2);
    const IrregularStars stars(refiner.complex(1));
    EXPECT_FALSE(stars.lines().empty());
    const FluxStars rows(stars, refiner.complex(2));
    // One at a time, rows give what applying them to all does.
    Cochain<2> form(refiner.complex(1));
    const auto values = testing::randomValues(form.size(), 1);
    std::copy(values.begin(), values.end(), form.data());
    std::vector<double> all(static_cast<std::size_t>(refiner.complex(2).edgeCount()), 0);
    rows.apply(form.data(), all.data());
    for (Index e = 0; e < refiner.complex(2).edgeCount(); ++e) {
      double sum = 0;
      rows.row(e, 1, [&](Index f, double w) { sum += w * form[f]; });
      ASSERT_NEAR(sum, all[static_cast<std::size_t>(e)], 1e-14);
    }
  }
}

}  // namespace
}  // namespace octet
