// SPDX-License-Identifier: Apache-2.0
#include "wall_rules.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <optional>
#include <tuple>

#include "../base/numbers.h"
#include "smoothing_rules.h"

namespace octet {
namespace {

/// Where the leading eigenvalues go, and what others are held to: along the wall at its second
/// harmonic and at higher ones, inside at points of a wall edge and anywhere else.
constexpr double kLeading = 1.0 / 2;
constexpr double kSecondHarmonic = 1.0 / 4, kHigherHarmonics = 1.0 / 5;
constexpr double kInsideAtEdges = 3.0 / 8, kInsideElsewhere = 3.0 / 10;

/// Moduli of eigenvalues that differ by less are not separated.
constexpr double kTie = 1e-7;
/// Boundary modes that decay more slowly than this must not shear the inside.
constexpr double kSlowMode = 0.35;
/// A rule with larger weights, or rows that do not sum to zero, is not used.
constexpr double kLargestWeight = 3, kRowSum = 1e-7;

constexpr int kRegularValence = 6;

/// @brief The matrix of a star without its moves, wall included.
Eigen::MatrixXd wallStarMatrix(const WallStar& wall) {
  const int n = wall.valence;
  Eigen::MatrixXd matrix = starMatrix(wall.star, n + 1);
  for (int k = 0; k < n; ++k) {
    const int label = k + 1;
    matrix(label, 0) = matrix(label, label) = 3.0 / 8;
    matrix(label, (k + 1) % n + 1) += 1.0 / 8;
    matrix(label, (k + n - 1) % n + 1) += 1.0 / 8;
  }
  matrix(0, 0) = 1 - n * loopBeta(n);
  for (int k = 1; k <= n; ++k) matrix(0, k) = loopBeta(n);
  return matrix;
}

/// @brief Moves of the inside of a star whose wall is known: the leading eigenvalue of the inside's
/// own block goes to 1/2, others above a bound are scaled down to it.
class InsideAssignment {
 public:
  /// @param matrix  of the star, wall moves included; labels 0..n are the wall
  InsideAssignment(Eigen::MatrixXd matrix, int valence)
      : matrix_(std::move(matrix)), wall_(valence + 1), inside_(matrix_.rows() - wall_) {}

  /// The moves, zero on wall rows; nothing where there is nothing to move.
  std::optional<Eigen::MatrixXd> moves() const {
    const Eigen::MatrixXd block = matrix_.bottomRightCorner(inside_, inside_);
    const double above = threshold(block);
    if (above < 0) return std::nullopt;
    const Eigen::MatrixXd right = invariantSubspace(block, above);
    const Eigen::MatrixXd left = invariantSubspace(block.transpose(), above);
    if (right.cols() != left.cols()) return std::nullopt;
    const Eigen::MatrixXd small = left.transpose() * block * left;
    const Eigen::MatrixXd ofInside =
        right * (left.transpose() * right).inverse() * (assigned(small) - small) * left.transpose();
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(matrix_.rows(), matrix_.cols());
    result.bottomRightCorner(inside_, inside_) = ofInside;
    result.bottomLeftCorner(inside_, wall_) = ofWall(ofInside);
    return result;
  }

 private:
  /// The modulus above which eigenvalues are touched; negative: none is.
  double threshold(const Eigen::MatrixXd& block) const {
    const Eigen::VectorXcd values = block.eigenvalues();
    std::vector<double> moduli(static_cast<std::size_t>(values.size()));
    for (std::size_t k = 0; k < moduli.size(); ++k) {
      moduli[k] = std::abs(values[static_cast<Eigen::Index>(k)]);
    }
    std::sort(moduli.begin(), moduli.end(), std::greater<>());
    std::size_t count = static_cast<std::size_t>(std::count_if(
        moduli.begin() + 1, moduli.end(), [](double x) { return x > kInsideElsewhere + 1e-9; }));
    ++count;
    if (count == 1 && std::abs(moduli[0] - kLeading) < 1e-9) return -1;
    while (count < moduli.size() && moduli[count - 1] - moduli[count] < kTie) ++count;
    return count < moduli.size() ? (moduli[count - 1] + moduli[count]) / 2 : 0;
  }

  /// The function of the small matrix that has the wanted eigenvalues.
  Eigen::MatrixXd assigned(const Eigen::MatrixXd& small) const {
    const Eigen::EigenSolver<Eigen::MatrixXd> eigen(small);
    Eigen::VectorXcd values = eigen.eigenvalues();
    Eigen::Index leading = 0;
    for (Eigen::Index k = 1; k < values.size(); ++k) {
      if (std::abs(values[k]) > std::abs(values[leading]) + kTie) leading = k;
    }
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      values[k] = k == leading ? std::complex<double>(kLeading)
                               : values[k] * std::min(1.0, kInsideElsewhere / std::abs(values[k]));
    }
    const Eigen::MatrixXcd vectors = eigen.eigenvectors();
    return (vectors * values.asDiagonal() * vectors.inverse()).real();
  }

  /// On the wall: the least-norm rows that keep constants, and that add nothing of the normal mode
  /// where slow modes of the wall bend it.
  Eigen::MatrixXd ofWall(const Eigen::MatrixXd& ofInside) const {
    const Eigen::MatrixXd wall = matrix_.topLeftCorner(wall_, wall_);
    const Eigen::MatrixXd coupling = matrix_.bottomLeftCorner(inside_, wall_);
    std::vector<Eigen::VectorXd> modes{Eigen::VectorXd::Ones(wall_)};
    std::vector<Eigen::VectorXd> images{-ofInside.rowwise().sum()};
    const Eigen::MatrixXd normal = normalMode(ofInside);
    const Eigen::EigenSolver<Eigen::MatrixXd> eigen(wall);
    for (Eigen::Index k = 0; k < wall_; ++k) {
      const std::complex<double> value = eigen.eigenvalues()[k];
      if (std::abs(value) <= kSlowMode || std::abs(value - 1.0) <= 1e-9) continue;
      for (const Eigen::VectorXd& z : {Eigen::VectorXd(eigen.eigenvectors().col(k).real()),
                                       Eigen::VectorXd(eigen.eigenvectors().col(k).imag())}) {
        if (z.norm() <= 1e-9) continue;
        modes.push_back(z);
        images.push_back(-normal * (coupling * z));
      }
    }
    const Eigen::Index count = static_cast<Eigen::Index>(modes.size());
    Eigen::MatrixXd from(wall_, count), to(inside_, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      from.col(k) = modes[static_cast<std::size_t>(k)];
      to.col(k) = images[static_cast<std::size_t>(k)];
    }
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse;
    inverse.setThreshold(1e-8);
    inverse.compute(from);
    return to * inverse.pseudoInverse();
  }

  /// The projection on the mode that goes to 1/2.
  Eigen::MatrixXd normalMode(const Eigen::MatrixXd& ofInside) const {
    const Eigen::MatrixXd moved = matrix_.bottomRightCorner(inside_, inside_) + ofInside;
    const auto vectorAtLeading = [](const Eigen::MatrixXd& of) {
      const Eigen::EigenSolver<Eigen::MatrixXd> eigen(of);
      Eigen::Index best = 0;
      for (Eigen::Index k = 1; k < of.rows(); ++k) {
        if (std::abs(eigen.eigenvalues()[k] - kLeading) <
            std::abs(eigen.eigenvalues()[best] - kLeading)) {
          best = k;
        }
      }
      return Eigen::VectorXd(eigen.eigenvectors().col(best).real());
    };
    const Eigen::VectorXd x = vectorAtLeading(moved), y = vectorAtLeading(moved.transpose());
    return x * y.transpose() / y.dot(x);
  }

  Eigen::MatrixXd matrix_;
  Eigen::Index wall_, inside_;
};

/// @brief The star of a point m inside a smooth wall edge with k tetrahedra, in the names of
/// section 8b, item 2: a+ and a- along the edge, r_j of either half with j = 0 and k on the wall,
/// o_j opposite m between r_j and r_{j+1}.
struct WallEdgeStar {
  int k = 0;
  int along[2];
  std::vector<int> ring[2], opposite;
};

/// Walks around the wall edge from m to ring label `along`, from ring label `start` inwards.
std::vector<int> walk(const Star& star, int along, int start) {
  std::vector<int> cells = cellsAtEdge(star, along), result{start};
  while (!cells.empty()) {
    const auto next = std::find_if(cells.begin(), cells.end(), [&](int cell) {
      return star.isTet(cell) &&
             std::count(star.tets[cell].begin(), star.tets[cell].end(), result.back()) > 0;
    });
    if (next == cells.end()) return {};
    for (const int v : star.tets[*next]) {
      if (v != 0 && v != along && v != result.back()) {
        result.push_back(v);
        break;
      }
    }
    cells.erase(next);
  }
  return result;
}

std::optional<WallEdgeStar> wallEdgeStar(const Star& star, int at) {
  const auto label = [&](int step) { return (at + step) % kRegularValence + 1; };
  WallEdgeStar named;
  named.along[0] = label(0);
  named.along[1] = label(3);
  named.ring[0] = walk(star, label(0), label(1));
  named.ring[1] = walk(star, label(3), label(2));
  named.k = static_cast<int>(named.ring[0].size()) - 1;
  if (named.k < 1 || named.ring[1].size() != named.ring[0].size() ||
      named.ring[0].back() != label(5) || named.ring[1].back() != label(4) ||
      static_cast<int>(star.octs.size()) != named.k) {
    return std::nullopt;
  }
  for (int j = 0; j < named.k; ++j) {
    const auto found = std::find_if(star.octs.begin(), star.octs.end(), [&](const auto& oct) {
      const auto has = [&](int v) { return std::find(oct.begin(), oct.end(), v) != oct.end(); };
      return has(named.ring[0][j]) && has(named.ring[0][j + 1]) && has(named.ring[1][j]) &&
             has(named.ring[1][j + 1]);
    });
    if (found == star.octs.end()) return std::nullopt;
    named.opposite.push_back((*found)[5]);
  }
  return named;
}

/// Item 2 in closed form.
Eigen::MatrixXd wallEdgeMoves(const Star& star, const WallEdgeStar& named) {
  const int k = named.k;
  struct Row {
    int label;
    bool opposite;
    double at;  // j, or j + 1/2 of an opposite
  };
  std::vector<Row> rows;
  for (const auto& ring : named.ring) {
    for (int j = 1; j < k; ++j) rows.push_back({ring[j], false, static_cast<double>(j)});
  }
  for (int j = 0; j < k; ++j) rows.push_back({named.opposite[j], true, j + 0.5});
  const auto count = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd inside = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd cosine(count);
  double firstValue = 0;
  for (int l = 1; l <= k; ++l) {
    const double theta = kPi * l / k, c = std::cos(theta);
    const double s = std::sqrt(std::max(0.0, (1 + c) / 2));
    const double p = 3.0 / 8 + 5 * c / 24, q = 1.0 / 6;
    const double value = l == k ? q : (p + q) / 2 + std::sqrt((p - q) * (p - q) / 4 + s * s / 36);
    const double alpha = l == k ? 1 : s / 24 / (value - q);
    const double beta = l == k ? 1 : 2 * s / 3 / (value - q);
    const double norm = l == k ? k : k * (1 + alpha * beta) / 2.0;
    const double wanted = l == 1 ? kLeading : std::min(value, kInsideAtEdges);
    Eigen::VectorXd x(count), y(count);
    for (Eigen::Index a = 0; a < count; ++a) {
      const Row& row = rows[static_cast<std::size_t>(a)];
      const double sine = l == k && !row.opposite ? 0 : std::sin(theta * row.at);
      x[a] = row.opposite ? beta * sine : sine;
      y[a] = row.opposite ? alpha * sine : sine / 2;
      if (l == 1) cosine[a] = k == 1 ? 0 : std::cos(theta * row.at) * (row.opposite ? beta : 1);
    }
    inside += (wanted - value) / norm * x * y.transpose();
    if (l == 1) firstValue = value;
  }
  const Eigen::VectorXd constants = -inside.rowwise().sum() / 7;
  const Eigen::VectorXd across = ((kLeading - firstValue) * cosine - inside * cosine) / 4;
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(star.vertexCount, star.vertexCount);
  for (Eigen::Index a = 0; a < count; ++a) {
    const int row = rows[static_cast<std::size_t>(a)].label;
    for (Eigen::Index b = 0; b < count; ++b) {
      moves(row, rows[static_cast<std::size_t>(b)].label) = inside(a, b);
    }
    for (const int v : {0, named.along[0], named.along[1]}) moves(row, v) += constants[a];
    for (const auto& ring : named.ring) {
      moves(row, ring.front()) += constants[a] + across[a];
      moves(row, ring.back()) += constants[a] - across[a];
    }
  }
  return moves;
}

/// Item 1: m's own row and its ring's.
void addSurfaceMoves(int n, Eigen::MatrixXd* moves) {
  const double change = smoothWallBeta(n) - loopBeta(n);
  const std::vector<double> ring = wallRingMoves(n);
  (*moves)(0, 0) -= n * change;
  for (int i = 0; i < n; ++i) {
    (*moves)(0, i + 1) += change;
    for (int j = 0; j < n; ++j) (*moves)(i + 1, j + 1) += ring[(j - i + n) % n];
  }
}

/// Number of tetrahedra and octahedra at a ring edge.
std::pair<int, int> kindAt(const Star& star, int ringEdge) {
  std::pair<int, int> kind{0, 0};
  for (const int cell : cellsAtEdge(star, ringEdge + 1)) {
    ++(star.isTet(cell) ? kind.first : kind.second);
  }
  return kind;
}

}  // namespace

bool WallStar::operator<(const WallStar& other) const {
  return std::tie(valence, star) < std::tie(other.valence, other.star);
}

double smoothWallBeta(int valence) {
  return valence == kRegularValence ? loopBeta(valence) : 3.0 / (8 * valence);
}

std::vector<double> wallRingMoves(int n) {
  std::vector<double> moves(static_cast<std::size_t>(n), 0.0);
  if (n == kRegularValence) return moves;
  for (int k = 1; 2 * k <= n; ++k) {
    const double theta = 2 * kPi * k / n, value = 3.0 / 8 + std::cos(theta) / 4;
    const double wanted = k == 1   ? kLeading
                          : k == 2 ? kSecondHarmonic
                                   : std::min(value, kHigherHarmonics);
    const double scale = (2 * k == n ? 1.0 : 2.0) / n * (wanted - value);
    for (int j = 0; j < n; ++j) moves[static_cast<std::size_t>(j)] += scale * std::cos(theta * j);
  }
  return moves;
}

Eigen::MatrixXd wallStarMoves(const WallStar& wall) {
  const int n = wall.valence;
  const Star& star = wall.star;
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(star.vertexCount, star.vertexCount);
  if (n != kRegularValence) addSurfaceMoves(n, &moves);
  if (star.vertexCount <= n + 1) return moves;
  if (n == kRegularValence) {
    std::vector<int> bad;
    for (int k = 0; k < n; ++k) {
      if (kindAt(star, k) != std::pair{1, 1}) bad.push_back(k);
    }
    if (bad.empty() && star.tets.size() == 4 && star.octs.size() == 3) return moves;
    if (bad.size() == 2 && bad[1] - bad[0] == 3 && kindAt(star, bad[0]) == kindAt(star, bad[1])) {
      if (const auto named = wallEdgeStar(star, bad[0])) return wallEdgeMoves(star, *named);
    }
  }
  const auto inside = InsideAssignment(wallStarMatrix(wall) + moves, n).moves();
  if (!inside || !inside->allFinite() || inside->cwiseAbs().maxCoeff() > kLargestWeight ||
      inside->rowwise().sum().cwiseAbs().maxCoeff() > kRowSum) {
    return moves;
  }
  return moves + *inside;
}

}  // namespace octet
