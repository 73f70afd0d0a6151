// SPDX-License-Identifier: Apache-2.0
// On the regular lattice the scheme is the thesis': stencils, limit masks and spectra are compared
// with exact rationals (tests/data/oracle) and with the tables of SCHEME.md section 5.
#include <Eigen/Eigenvalues>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include <gtest/gtest.h>

#include <octet/core/field/limit_masks.h>
#include <octet/core/refine/refiner.h>

#include "tests/support/meshes.h"
#include "tests/support/test_data.h"

namespace octet {
namespace {

using Point = std::vector<int>;
using Simplex = std::vector<Point>;

nlohmann::json readOracle(const std::string& name) {
  std::ifstream file(testing::testData("oracle/" + name));
  return nlohmann::json::parse(file);
}

double rational(const std::string& text) {
  const auto slash = text.find('/');
  if (slash == std::string::npos) return std::stod(text);
  return std::stod(text.substr(0, slash)) / std::stod(text.substr(slash + 1));
}

/// A piece of the lattice big enough to hold a 2-ring around its middle, once refined.
class LatticePiece {
 public:
  explicit LatticePiece(double zeta) : refiner_(make(zeta)) {
    for (Index v = 0; v < refiner_.complex(0).vertexCount(); ++v) {
      const Vec3& p = refiner_.positions(0)[v];
      coarse_[{static_cast<int>(p[0]), static_cast<int>(p[1]), static_cast<int>(p[2])}] = v;
    }
    // A fine vertex of the linear split sits at its topological place in the lattice of half the
    // spacing.
    const Complex& c = refiner_.complex(0);
    for (const auto& [p, v] : coarse_) points_[v] = p;
    for (Index v = 0; v < refiner_.complex(1).vertexCount(); ++v) {
      Index a = v, b = v;
      if (v >= c.vertexCount() + c.edgeCount()) {
        a = c.octs[v - c.vertexCount() - c.edgeCount()][0];
        b = c.octs[v - c.vertexCount() - c.edgeCount()][5];
      } else if (v >= c.vertexCount()) {
        a = c.edges[v - c.vertexCount()][0];
        b = c.edges[v - c.vertexCount()][1];
      }
      fine_[{points_[a][0] + points_[b][0], points_[a][1] + points_[b][1],
             points_[a][2] + points_[b][2]}] = v;
    }
  }

  const Refiner& refiner() const { return refiner_; }
  Index coarse(const Point& p) const { return coarse_.at(p); }
  Index fine(const Point& p) const { return fine_.at(p); }
  const Point& point(Index coarseVertex) const { return points_.at(coarseVertex); }

 private:
  static Refiner make(double zeta) {
    RefinerOptions options;
    options.levels = 1;
    options.zeta = zeta;
    const auto inside = [](int x, int y, int z) {
      return std::abs(x) <= 4 && std::abs(y) <= 4 && std::abs(z) <= 4;
    };
    return Refiner(ControlMesh::build(testing::latticeBlock(inside, 4)), options);
  }

  Refiner refiner_;
  std::map<Point, Index> coarse_, fine_;
  std::map<Index, Point> points_;
};

/// Index of the simplex with these vertices, and +1 or -1 for the order they are given in.
template <int K>
std::pair<Index, double> findSimplex(const Complex& c, const std::vector<Index>& v) {
  for (Index s = 0; s < c.count(K); ++s) {
    std::vector<Index> stored;
    if constexpr (K == 0) stored = {s};
    if constexpr (K == 1) stored.assign(c.edges[s].begin(), c.edges[s].end());
    if constexpr (K == 2) {
      const auto t = c.facetVertices(s);
      stored.assign(t.begin(), t.end());
    }
    if (!std::is_permutation(stored.begin(), stored.end(), v.begin(), v.end())) continue;
    double sign = 1;
    for (std::size_t i = 0; i < v.size(); ++i) {
      for (std::size_t j = i + 1; j < v.size(); ++j) {
        const auto place = [&](Index x) { return std::find(v.begin(), v.end(), x) - v.begin(); };
        if (place(stored[i]) > place(stored[j])) sign = -sign;
      }
    }
    return {s, sign};
  }
  ADD_FAILURE() << "simplex not found";
  return {0, 0};
}

/// The row of a fine simplex, as weights on coarse simplices by their sorted points.
template <int K>
std::map<Simplex, double> stencil(const LatticePiece& lattice, const Simplex& target) {
  const Refiner& refiner = lattice.refiner();
  const Complex& c = refiner.complex(0);
  std::vector<Index> v;
  for (const Point& p : target) v.push_back(lattice.fine(p));
  const auto [row, sign] = findSimplex<K>(refiner.complex(1), v);
  std::map<Simplex, double> result;
  for (Index s = 0; s < c.count(K); ++s) {
    std::vector<Index> vertices;
    if constexpr (K == 0) vertices = {s};
    if constexpr (K == 1) vertices = {c.edges[s][0], c.edges[s][1]};
    if constexpr (K == 2) {
      const auto t = c.facetVertices(s);
      vertices = {t[0], t[1], t[2]};
    }
    // Only simplices near the target can matter; that others do not is checked by the sum.
    Simplex points;
    bool near = true;
    for (const Index x : vertices) {
      points.push_back(lattice.point(x));
      for (int k = 0; k < 3; ++k) near &= std::abs(2 * points.back()[k] - target[0][k]) <= 6;
    }
    if (!near) continue;
    Cochain<K> unit(c);
    unit[s] = 1;
    const double w = sign * refiner.step(0, unit, BoundaryMode::Walls)[row];
    if (std::abs(w) > 1e-14) result[points] = w;
  }
  return result;
}

/// Brings a simplex to sorted order; the weight changes sign with the orientation.
std::pair<Simplex, double> sorted(Simplex s, double w) {
  for (std::size_t i = 0; i < s.size(); ++i) {
    for (std::size_t j = i + 1; j < s.size(); ++j) {
      if (s[j] < s[i]) {
        std::swap(s[i], s[j]);
        w = -w;
      }
    }
  }
  return {s, w};
}

template <int K>
void expectStencil(const LatticePiece& lattice, const Simplex& target,
                   const std::map<Simplex, double>& expected) {
  std::map<Simplex, double> actual;
  for (const auto& [s, w] : stencil<K>(lattice, target)) {
    const auto [key, value] = sorted(s, w);
    actual[key] = value;
  }
  EXPECT_EQ(actual.size(), expected.size());
  for (const auto& [s, w] : expected) {
    ASSERT_TRUE(actual.count(s));
    EXPECT_NEAR(actual[s], w, 1e-14);
  }
}

TEST(Regular, ZeroFormStencilsAreThePrintedOnes) {
  const LatticePiece lattice(kDefaultZeta);
  for (const auto& [name, entry] : readOracle("regular_stencils.json").at("zero_forms").items()) {
    SCOPED_TRACE(name);
    std::map<Simplex, double> expected;
    for (const auto& term : entry.at("terms")) {
      expected[{term.at("source").get<Point>()}] = rational(term.at("weight"));
    }
    expectStencil<0>(lattice, {entry.at("target").get<Point>()}, expected);
  }
}

TEST(Regular, EdgeAndFacetStencilsEqualTheOracleForEveryZeta) {
  const auto oracle = readOracle("regular_stencils.json").at("stencils");
  for (const double zeta : {-5.0, -6.2}) {
    const LatticePiece lattice(zeta);
    const double q = (1.0 / 3 - (zeta + 6) / 8) / 2;
    for (const auto& [name, entry] : oracle.items()) {
      SCOPED_TRACE(name + " at zeta " + std::to_string(zeta));
      std::map<Simplex, double> expected;
      for (const auto& term : entry.at("terms")) {
        const double w = rational(term.at("const")) + q * rational(term.at("coef"));
        const auto [key, value] = sorted(term.at("source").get<Simplex>(), w);
        if (std::abs(value) > 1e-14) expected[key] = value;
      }
      const auto target = entry.at("target").get<Simplex>();
      if (target.size() == 2) {
        expectStencil<1>(lattice, target, expected);
      } else {
        expectStencil<2>(lattice, target, expected);
      }
    }
  }
}

TEST(Regular, LimitMasksEqualTheOracle) {
  const auto oracle = readOracle("limit_masks.json");
  const LimitMasks masks(kDefaultZeta);
  const Lattice& lattice = Lattice::get();
  const auto pointOf = [&](std::uint8_t k) {
    return Point(lattice.neighbours[k].begin(), lattice.neighbours[k].end());
  };
  const auto vector = [](const nlohmann::json& list) {
    Vec3 v;
    for (int k = 0; k < 3; ++k) v[k] = rational(list[static_cast<std::size_t>(k)]);
    return v;
  };
  std::map<Simplex, Vec3> expected[3];
  for (const auto& term : oracle.at("degree0")) {
    expected[0][{term.at("at").get<Point>()}] = {rational(term.at("weight")), 0, 0};
  }
  for (const int degree : {1, 2}) {
    for (const auto& term : oracle.at("degree" + std::to_string(degree))) {
      const auto [key, sign] = sorted(term.at(degree == 1 ? "edge" : "facet").get<Simplex>(), 1.0);
      expected[degree][key] = sign * vector(term.at("weight"));
    }
  }
  for (int degree = 0; degree < 3; ++degree) {
    ASSERT_TRUE(masks.exists[degree]);
    EXPECT_EQ(masks.terms[degree].size(), expected[degree].size());
    for (const MaskTerm& term : masks.terms[degree]) {
      Simplex key;
      for (int k = 0; k <= degree; ++k) key.push_back(pointOf(term.vertices[k]));
      ASSERT_TRUE(expected[degree].count(key));
      EXPECT_LT((term.weight - expected[degree][key]).norm(), 1e-12);
    }
  }
}

/// The subdivision matrix of the 1-ring M_E, column by column.
template <int K>
Eigen::MatrixXd oneRingMatrix() {
  const LatticePiece lattice(kDefaultZeta);
  const Refiner& refiner = lattice.refiner();
  const Complex &c = refiner.complex(0), &f = refiner.complex(1);
  // Simplices in the closed star of the origin: those of its 14 cells.
  const auto closedStar = [](const Complex& complex, Index vertex) {
    std::set<Index> result;
    complex.visitVertexStar(vertex, [&](const CellAtVertex& at) {
      for (int k = 0; k < complex.cellFacetCount(at.cell); ++k) {
        const Index facet = complex.cellFacet(at.cell, k).index();
        if (K == 2) result.insert(facet);
        if (K == 1) {
          for (const EdgeRef& e : complex.facetEdges[facet]) result.insert(e.index());
        }
        if (K == 0) {
          for (const Index v : complex.facetVertices(facet)) result.insert(v);
        }
      }
    });
    return std::vector<Index>(result.begin(), result.end());
  };
  const auto coarse = closedStar(c, lattice.coarse({0, 0, 0}));
  const auto fine = closedStar(f, lattice.fine({0, 0, 0}));
  // Pair each fine simplex with the coarse one of twice the size.
  std::map<Index, Point> finePoint;
  for (int x = -4; x <= 4; ++x) {
    for (int y = -4; y <= 4; ++y) {
      for (int z = -4; z <= 4; ++z) {
        if ((x + y + z) % 2 == 0) finePoint[lattice.fine({x, y, z})] = {x, y, z};
      }
    }
  }
  const auto simplexAt = [&](const Complex& complex, Index s, const auto& point) {
    Simplex points;
    if constexpr (K == 0) points = {point(s)};
    if constexpr (K == 1) points = {point(complex.edges[s][0]), point(complex.edges[s][1])};
    if constexpr (K == 2) {
      const auto v = complex.facetVertices(s);
      points = {point(v[0]), point(v[1]), point(v[2])};
    }
    return sorted(points, 1.0);
  };
  std::map<Simplex, std::pair<Index, double>> fineBy;
  for (const Index s : fine) {
    const auto [key, sign] = simplexAt(f, s, [&](Index v) { return finePoint.at(v); });
    fineBy[key] = {s, sign};
  }
  const Eigen::Index n = static_cast<Eigen::Index>(coarse.size());
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index column = 0; column < n; ++column) {
    Cochain<K> unit(c);
    unit[coarse[static_cast<std::size_t>(column)]] = 1;
    const auto refined = refiner.step(0, unit, BoundaryMode::Walls);
    for (Eigen::Index row = 0; row < n; ++row) {
      const auto [key, sign] = simplexAt(c, coarse[static_cast<std::size_t>(row)],
                                         [&](Index v) { return lattice.point(v); });
      const auto [s, fineSign] = fineBy.at(key);
      matrix(row, column) = refined[s] * sign * fineSign;
    }
  }
  return matrix;
}

void expectSpectrum(const Eigen::MatrixXd& matrix,
                    const std::vector<std::pair<double, int>>& expected) {
  std::vector<double> actual;
  const auto eigenvalues = matrix.eigenvalues();
  for (Eigen::Index k = 0; k < eigenvalues.size(); ++k) {
    // Defective eigenvalues spread by the root of rounding.
    EXPECT_NEAR(eigenvalues[k].imag(), 0, 1e-5);
    actual.push_back(eigenvalues[k].real());
  }
  std::sort(actual.rbegin(), actual.rend());
  std::vector<double> wanted;
  for (const auto& [value, multiplicity] : expected) {
    wanted.insert(wanted.end(), static_cast<std::size_t>(multiplicity), value);
  }
  ASSERT_EQ(actual.size(), wanted.size());
  for (std::size_t k = 0; k < wanted.size(); ++k) EXPECT_NEAR(actual[k], wanted[k], 1e-5);
}

TEST(Regular, SpectraOfTheOneRingAreThoseOfTheTable) {
  expectSpectrum(oneRingMatrix<0>(),
                 {{1, 1}, {1. / 2, 3}, {1. / 4, 6}, {1. / 8, 6}, {5. / 48, 1}, {1. / 12, 2}});
  expectSpectrum(oneRingMatrix<1>(), {{1. / 2, 3},
                                      {1. / 4, 9},
                                      {1. / 8, 17},
                                      {5. / 48, 1},
                                      {1. / 12, 2},
                                      {1. / 16, 16},
                                      {3. / 64, 3},
                                      {7. / 192, 3},
                                      {1. / 32, 4},
                                      {1. / 48, 2}});
  expectSpectrum(oneRingMatrix<2>(), {{1. / 4, 3},
                                      {1. / 8, 12},
                                      {1. / 16, 20},
                                      {3. / 64, 3},
                                      {7. / 192, 3},
                                      {1. / 32, 10},
                                      {1. / 48, 2},
                                      {1. / 64, 3}});
}

TEST(Regular, HomotopyRowsMakeTheSameAverages) {
  // Where regular and irregular simplices meet both descriptions are used side by side; on a
  // lattice with holes every class does, and d S = S d (refiner_test) would break. Here: their
  // size.
  const Lattice& lattice = Lattice::get();
  for (const auto& row : lattice.edgeHomotopy) EXPECT_EQ(row.size(), 76u);
  for (const auto& row : lattice.facetHomotopy) EXPECT_EQ(row.size(), 32u);
}

TEST(Regular, NoLimitIsClaimedWhereThereIsNone) {
  const LimitMasks masks(-4.0);  // p = 1/4: as large as the 2-form's own eigenvalue
  EXPECT_TRUE(masks.exists[1]);
  EXPECT_FALSE(masks.exists[2]);
}

}  // namespace
}  // namespace octet
