// SPDX-License-Identifier: Apache-2.0
#include "interior_rules.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <set>
#include <tuple>

#include "../base/numbers.h"

namespace octet {
namespace {

/// Where leading eigenvalues go, and what the others are held to.
constexpr double kLeading = 1.0 / 2, kOthers = 3.0 / 10;
/// Eigenvalues whose moduli differ by less form a cluster, which is never divided.
constexpr double kTie = 1e-8;
/// Clusters among which the leading ones are looked for.
constexpr int kRanks = 8;
/// A rule that is worse conditioned than this is not used.
constexpr double kWorstCondition = 1e8;
/// An embedded star shows m all its outer facets from one side, none of them nearly edge-on.
constexpr double kEdgeOn = 1e-9;

/// Singular values below this, relative to the largest, are nothing.
constexpr double kFlat = 1e-9;

using Triangle = std::array<int, 3>;

/// The facets of a star that avoid m, as one consistently oriented surface.
std::vector<Triangle> outerFacets(const Star& star) {
  std::vector<Triangle> facets;
  for (const auto& tet : star.tets) facets.push_back({tet[1], tet[2], tet[3]});
  for (const auto& oct : star.octs) {
    for (int k = 0; k < 4; ++k) facets.push_back({oct[1 + k], oct[1 + (k + 1) % 4], oct[5]});
  }
  std::map<std::pair<int, int>, std::vector<std::size_t>> atEdge;
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (int k = 0; k < 3; ++k) {
      atEdge[std::minmax(facets[f][k], facets[f][(k + 1) % 3])].push_back(f);
    }
  }
  // Neighbours run along their common edge in opposite directions.
  std::vector<char> done(facets.size(), 0);
  std::vector<std::size_t> front{0};
  done[0] = 1;
  const auto runs = [&](std::size_t f, int a, int b) {
    for (int k = 0; k < 3; ++k) {
      if (facets[f][k] == a && facets[f][(k + 1) % 3] == b) return true;
    }
    return false;
  };
  while (!front.empty()) {
    const std::size_t f = front.back();
    front.pop_back();
    for (int k = 0; k < 3; ++k) {
      const int a = facets[f][k], b = facets[f][(k + 1) % 3];
      for (const std::size_t g : atEdge[std::minmax(a, b)]) {
        if (done[g]) continue;
        if (runs(g, a, b)) std::swap(facets[g][0], facets[g][1]);
        done[g] = 1;
        front.push_back(g);
      }
    }
  }
  return facets;
}

/// Do functions on a star, as coordinates relative to m, show m all its outer facets from one side?
/// False where they do not span three dimensions.
bool embeds(Eigen::MatrixXd functions, const std::vector<Triangle>& facets) {
  const Eigen::RowVectorXd centre = functions.row(0);
  functions.rowwise() -= centre;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(functions, Eigen::ComputeThinU);
  const auto& sizes = svd.singularValues();
  if (sizes.size() < 3 || sizes[2] < kFlat * sizes[0]) return false;
  if (sizes.size() > 3 && sizes[3] > kFlat * sizes[0]) return false;
  const Eigen::MatrixXd places = svd.matrixU().leftCols(3);
  std::vector<double> sides;
  double sum = 0;
  for (const Triangle& t : facets) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.row(k) = places.row(t[static_cast<std::size_t>(k)]);
    sides.push_back(corners.determinant());
    sum += sides.back();
  }
  if (sum < 0) {
    for (double& side : sides) side = -side;
  }
  const auto [least, most] = std::minmax_element(sides.begin(), sides.end());
  return *least > kEdgeOn * *most;
}

/// Eigenvalues of equal modulus.
struct Cluster {
  double modulus;
  std::vector<Eigen::Index> columns;
};

std::vector<Cluster> clustersOf(const Eigen::VectorXcd& values) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(values.size()));
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Eigen::Index>(k);
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::abs(values[a]) > std::abs(values[b]);
  });
  std::vector<Cluster> clusters;
  double last = 0;
  for (const Eigen::Index k : order) {
    const double modulus = std::abs(values[k]);
    if (clusters.empty() || last - modulus >= kTie) clusters.push_back({modulus, {}});
    clusters.back().columns.push_back(k);
    last = modulus;
  }
  return clusters;
}

/// @brief Assigns the eigenvalues of a star's matrix, or of its part that is even in a reflection.
class Assignment {
 public:
  /// @param movable  rows that may change
  /// @param facets   the surface that leading eigenvectors must embed; empty: no such condition
  Assignment(const Eigen::MatrixXd& matrix, std::vector<Eigen::Index> movable, int leading,
             std::vector<Triangle> facets)
      : matrix_(matrix),
        movable_(std::move(movable)),
        facets_(std::move(facets)),
        wanted_(static_cast<std::size_t>(leading)),
        eigen_(matrix),
        clusters_(clustersOf(eigen_.eigenvalues())) {}

  std::optional<Eigen::MatrixXd> moves() {
    if (std::abs(clusters_[0].modulus - 1) > kTie || clusters_[0].columns.size() > 1) return {};
    chooseLeading();
    const double cut = threshold();
    const Eigen::MatrixXd right = invariantSubspace(matrix_, cut);
    const Eigen::MatrixXd left = invariantSubspace(matrix_.transpose(), cut);
    if (right.cols() != left.cols()) return {};
    const Eigen::MatrixXd small = left.transpose() * matrix_ * left;
    Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(right.rows(), right.cols());
    for (const Eigen::Index row : movable_) moved.row(row) = right.row(row);
    const Eigen::MatrixXd gram = left.transpose() * moved;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(gram);
    const auto& sizes = svd.singularValues();
    if (!(sizes[0] <= kWorstCondition * sizes[sizes.size() - 1])) return {};
    return moved * gram.partialPivLu().solve((assigned(small) - small) * left.transpose());
  }

 private:
  /// The first union of clusters after the 1, in lexicographic order of ranks, that has as many
  /// eigenvalues as wanted and embeds the star; else the clusters in order.
  void chooseLeading() {
    const int last = std::min<int>(static_cast<int>(clusters_.size()) - 1, kRanks);
    std::vector<int> ranks;
    const auto search = [&](const auto& self, int from, std::size_t count) -> bool {
      if (count == wanted_ && embeds(ranks)) {
        leading_.insert(ranks.begin(), ranks.end());
        return true;
      }
      for (int k = from; k <= last && count < wanted_; ++k) {
        const std::size_t with = count + clusters_[static_cast<std::size_t>(k)].columns.size();
        if (with > wanted_) continue;
        ranks.push_back(k);
        if (self(self, k + 1, with)) return true;
        ranks.pop_back();
      }
      return false;
    };
    if (search(search, 1, 0)) return;
    std::size_t count = 0;
    for (std::size_t k = 1; k < clusters_.size() && count < wanted_; ++k) {
      leading_.insert(static_cast<int>(k));
      count += clusters_[k].columns.size();
    }
  }

  bool embeds(const std::vector<int>& ranks) const {
    if (facets_.empty()) return true;
    std::vector<Eigen::VectorXd> columns;
    for (const int rank : ranks) {
      for (const Eigen::Index k : clusters_[static_cast<std::size_t>(rank)].columns) {
        columns.push_back(eigen_.eigenvectors().col(k).real());
        columns.push_back(eigen_.eigenvectors().col(k).imag());
      }
    }
    Eigen::MatrixXd all(matrix_.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t k = 0; k < columns.size(); ++k) {
      all.col(static_cast<Eigen::Index>(k)) = columns[k];
    }
    return octet::embeds(all, facets_);
  }

  /// Between the last cluster that is touched and the one after it.
  double threshold() const {
    std::size_t last = 0;
    for (std::size_t k = 0; k < clusters_.size(); ++k) {
      if (leading_.count(static_cast<int>(k)) || clusters_[k].modulus > kOthers + kTie) last = k;
    }
    const double below = last + 1 < clusters_.size() ? clusters_[last + 1].modulus : 0;
    return (clusters_[last].modulus + below) / 2;
  }

  /// The same function of the small matrix as is wanted of the star's.
  Eigen::MatrixXd assigned(const Eigen::MatrixXd& small) const {
    const Eigen::EigenSolver<Eigen::MatrixXd> eigen(small);
    Eigen::VectorXcd values = eigen.eigenvalues();
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const double modulus = std::abs(values[k]);
      std::size_t nearest = 0;
      for (std::size_t j = 1; j < clusters_.size(); ++j) {
        if (std::abs(clusters_[j].modulus - modulus) <
            std::abs(clusters_[nearest].modulus - modulus)) {
          nearest = j;
        }
      }
      if (nearest == 0) continue;
      values[k] = leading_.count(static_cast<int>(nearest))
                      ? std::complex<double>(kLeading)
                      : values[k] * std::min(1.0, kOthers / modulus);
    }
    const Eigen::MatrixXcd vectors = eigen.eigenvectors();
    return (vectors * values.asDiagonal() * vectors.inverse()).real();
  }

  Eigen::MatrixXd matrix_;
  std::vector<Eigen::Index> movable_;
  std::vector<Triangle> facets_;
  std::size_t wanted_;
  Eigen::EigenSolver<Eigen::MatrixXd> eigen_;
  std::vector<Cluster> clusters_;
  std::set<int> leading_;
};

/// On a line with octahedra around it: functions that are even in the reflection, one unknown for
/// each pair of images.
std::optional<Eigen::MatrixXd> evenMoves(const InteriorStar& star, const Eigen::MatrixXd& matrix,
                                         const std::vector<Eigen::Index>& movable) {
  std::vector<Eigen::Index> lead;
  for (Eigen::Index label = 0; label < matrix.rows(); ++label) {
    if (label <= star.mirror[static_cast<std::size_t>(label)]) lead.push_back(label);
  }
  const auto count = static_cast<Eigen::Index>(lead.size());
  Eigen::MatrixXd pairs = Eigen::MatrixXd::Zero(matrix.rows(), count);
  Eigen::MatrixXd even(count, count);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index label = lead[static_cast<std::size_t>(k)];
    pairs(label, k) = pairs(star.mirror[static_cast<std::size_t>(label)], k) = 1;
    if (std::find(movable.begin(), movable.end(), label) != movable.end()) rows.push_back(k);
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    even.row(k) = matrix.row(lead[static_cast<std::size_t>(k)]) * pairs;
  }
  const auto moves = Assignment(even, rows, 2, {}).moves();
  if (!moves) return {};
  const Eigen::VectorXd sizes = pairs.colwise().sum();
  return pairs * *moves * sizes.cwiseInverse().asDiagonal() * pairs.transpose();
}

}  // namespace

bool InteriorStar::operator<(const InteriorStar& other) const {
  return std::tie(onLine, axis[0], axis[1], mirror, star) <
         std::tie(other.onLine, other.axis[0], other.axis[1], other.mirror, other.star);
}

LineMoves lineMoves(int n) {
  LineMoves moves{std::vector<double>(static_cast<std::size_t>(n), 0.0),
                  std::vector<double>(static_cast<std::size_t>(n), 0.0)};
  for (int k = 1; 2 * k <= n; ++k) {
    const double theta = 2 * kPi * k / n, c = std::cos(theta);
    const double h = std::sqrt(std::max(0.0, (1 + c) / 2));
    const double p = 3.0 / 8 + 5 * c / 24, q = 1.0 / 6;
    const double value = (p + q) / 2 + std::sqrt((p - q) * (p - q) / 4 + h * h / 36);
    const double rho = 2 * k == n ? 0 : h / 24 / (value - q);
    const double wanted = k == 1 ? kLeading : std::min(value, kOthers);
    const double scale = (2 * k == n ? 1.0 : 2.0) / n * (wanted - value);
    for (int j = 0; 2 * j <= n; ++j) {
      moves.ring[static_cast<std::size_t>(j)] += scale / 2 * std::cos(theta * j);
      moves.beyond[static_cast<std::size_t>(j)] += scale * rho * std::cos(theta * (j + 0.5));
    }
  }
  // The other half is the same, bit for bit, so that no start or direction is preferred.
  for (int j = 1; j < n; ++j) {
    const auto at = static_cast<std::size_t>(j), back = static_cast<std::size_t>(n - j);
    if (2 * j > n) moves.ring[at] = moves.ring[back];
    if (2 * j >= n) moves.beyond[at] = moves.beyond[back - 1];
  }
  return moves;
}

InteriorRule interiorRule(const InteriorStar& interior) {
  const Star& star = interior.star;
  Eigen::MatrixXd matrix = starMatrix(star);
  std::vector<Eigen::Index> movable;
  for (int label = 1; label < star.vertexCount; ++label) {
    const bool onAxis = interior.onLine && (label == interior.axis[0] || label == interior.axis[1]);
    if (!onAxis && adjacentToCentre(star, label)) movable.push_back(label);
  }
  const std::vector<Triangle> facets = outerFacets(star);
  InteriorRule rule;
  rule.moves = interior.onLine ? evenMoves(interior, matrix, movable)
                               : Assignment(matrix, movable, 3, facets).moves();
  if (rule.moves) matrix += *rule.moves;
  rule.limit = limitWeights(matrix);
  rule.folds = !embeds(invariantSubspace(matrix, (kLeading + kOthers) / 2), facets);
  return rule;
}

InteriorRule lineRule(int n) {
  const auto label = [n](int group, int j) { return 3 + group * n + (j % n + n) % n; };
  const auto byte = [](int k) { return static_cast<std::uint8_t>(k); };
  enum { kUpper, kLower, kBeyond };
  Star star;
  star.vertexCount = 3 + 3 * n;
  for (const int group : {kUpper, kLower}) {
    for (int j = 0; j < n; ++j) {
      std::array<std::uint8_t, 4> tet{0, byte(1 + group), byte(label(group, j)),
                                      byte(label(group, j + 1))};
      std::sort(tet.begin(), tet.end());
      star.tets.push_back(tet);
    }
  }
  for (int j = 0; j < n; ++j) {
    star.octs.push_back({0, byte(label(kUpper, j)), byte(label(kUpper, j + 1)),
                         byte(label(kLower, j + 1)), byte(label(kLower, j)),
                         byte(label(kBeyond, j))});
  }
  const LineMoves line = lineMoves(n);
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(star.vertexCount, star.vertexCount);
  for (const int group : {kUpper, kLower}) {
    for (int i = 0; i < n; ++i) {
      const int row = label(group, i);
      for (int j = 0; j < n; ++j) {
        const auto step = static_cast<std::size_t>((j - i + n) % n);
        moves(row, label(kUpper, j)) = moves(row, label(kLower, j)) = line.ring[step];
        moves(row, label(kBeyond, j)) = line.beyond[step];
      }
      moves(row, 0) = -moves.row(row).sum();
    }
  }
  InteriorRule rule;
  rule.limit = limitWeights(starMatrix(star) + moves);
  rule.moves = std::move(moves);
  return rule;
}

Eigen::VectorXd twinLimit() {
  constexpr std::uint8_t kRing = 1;
  Star star;
  star.vertexCount = 19;
  for (const std::uint8_t side : {0, 3}) {  // above, below
    const auto near = [side](int k) { return static_cast<std::uint8_t>(7 + side + k % 3); };
    const auto far = [side](int k) { return static_cast<std::uint8_t>(13 + side + k); };
    const auto ring = [](int j) { return static_cast<std::uint8_t>(kRing + j % 6); };
    star.tets.push_back({0, near(0), near(1), near(2)});
    for (int k = 0; k < 3; ++k) {
      star.tets.push_back({0, ring(2 * k), ring(2 * k + 1), near(k)});
      star.octs.push_back({0, ring(2 * k + 1), ring(2 * k + 2), near(k + 1), near(k), far(k)});
    }
  }
  return limitWeights(starMatrix(star));
}

}  // namespace octet
