// SPDX-License-Identifier: Apache-2.0
#include "interior_moves.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <tuple>

#include "../base/parallel.h"
#include "interior_limits.h"
#include "solved_stars.h"
#include "twin_stars.h"

namespace octet {
namespace {

/// An interior star as it lies in the mesh.
struct LabelledInteriorStar {
  std::vector<Index> vertices;
  InteriorStar interior;
};

/// @brief Labels interior stars in their canonical form.
class InteriorLabels {
 public:
  InteriorLabels(const Complex& complex, Index centre, const LineStar* line)
      : c_(complex), centre_(centre), line_(line) {}

  /// The least labelling over all beginnings: a facet at the vertex, seen from one of its edges and
  /// one of its cells; the axis comes first on a line, elsewhere the rarest kind of edge.
  std::optional<LabelledInteriorStar> canonical() const {
    std::optional<LabelledInteriorStar> best;
    for (const Beginning& beginning : beginnings()) {
      auto star = walkStar(c_, centre_, {beginning.first, beginning.second}, {beginning.cell});
      if (!star) return std::nullopt;
      LabelledInteriorStar candidate{std::move(star->vertices), {}};
      candidate.interior.star = std::move(star->star);
      if (line_) describeLine(&candidate);
      if (!best || candidate.interior < best->interior) best = std::move(candidate);
    }
    return best;
  }

 private:
  struct Beginning {
    Index first, second, cell;
    std::array<int, 5> signature;  // how rare the first edge is, and the kinds of both
  };

  std::vector<Beginning> beginnings() const {
    std::map<Index, std::pair<int, int>> kinds;  // tetrahedra and octahedra at each edge
    c_.visitVertexStar(centre_, [&](const CellAtVertex& at) {
      for (int k = 0; k < c_.cellVertexCount(at.cell); ++k) {
        if (k == at.place) continue;
        if (c_.isTet(at.cell)) {
          ++kinds[c_.cellVertex(at.cell, k)].first;
        } else if (Octahedron::opposite[at.place] != k) {
          ++kinds[c_.cellVertex(at.cell, k)].second;
        }
      }
    });
    std::map<std::pair<int, int>, int> frequency;
    for (const auto& [v, kind] : kinds) ++frequency[kind];
    std::vector<Beginning> all;
    c_.visitVertexStar(centre_, [&](const CellAtVertex& at) {
      for (int k = 0; k < c_.cellFacetCount(at.cell); ++k) {
        const auto t = c_.facetVertices(c_.cellFacet(at.cell, k).index());
        const auto where = std::find(t.begin(), t.end(), centre_);
        if (where == t.end()) continue;
        const auto p = static_cast<std::size_t>(where - t.begin());
        for (const auto& [a, b] : {std::pair{t[(p + 1) % 3], t[(p + 2) % 3]},
                                   std::pair{t[(p + 2) % 3], t[(p + 1) % 3]}}) {
          if (line_ && a != line_->up && a != line_->down) continue;
          const auto &first = kinds[a], &second = kinds[b];
          all.push_back(
              {a,
               b,
               at.cell,
               {frequency[first], first.first, first.second, second.first, second.second}});
        }
      }
    });
    const auto least = std::min_element(all.begin(), all.end(), [](const auto& x, const auto& y) {
      return x.signature < y.signature;
    });
    if (least == all.end()) return all;
    const auto signature = least->signature;
    all.erase(std::remove_if(all.begin(), all.end(),
                             [&](const Beginning& b) { return b.signature != signature; }),
              all.end());
    return all;
  }

  void describeLine(LabelledInteriorStar* labelled) const {
    const auto labelOf = [&](Index v) {
      return static_cast<std::uint8_t>(
          std::find(labelled->vertices.begin(), labelled->vertices.end(), v) -
          labelled->vertices.begin());
    };
    InteriorStar& star = labelled->interior;
    star.onLine = true;
    star.axis[0] = labelOf(line_->up);
    star.axis[1] = labelOf(line_->down);
    if (star.axis[0] > star.axis[1]) std::swap(star.axis[0], star.axis[1]);
    for (const Index v : labelled->vertices) star.mirror.push_back(labelOf(line_->imageOf(v)));
  }

  const Complex& c_;
  Index centre_;
  const LineStar* line_;
};

/// A star's vertices by label, and its rule.
struct RuledStar {
  std::vector<Index> vertices;
  std::shared_ptr<const InteriorRule> rule;
};

/// The rule of a star, with its vertices by label; none where the star has no labels.
std::optional<RuledStar> ruledStar(const IrregularStars& stars, Index centre,
                                   const LineStar* line) {
  static SolvedStars<InteriorStar, InteriorRule> solved(interiorRule);
  static SolvedStars<int, InteriorRule> solvedLines([](const int& n) { return lineRule(n); });
  constexpr int kFewestTetrahedra = 3;
  if (line) {
    const LineNames names = stars.names(*line);
    if (names.size() >= kFewestTetrahedra)
      return RuledStar{names.list(), solvedLines(names.size())};
  }
  auto labelled = InteriorLabels(stars.complex(), centre, line).canonical();
  if (!labelled) return std::nullopt;
  return RuledStar{std::move(labelled->vertices), solved(labelled->interior)};
}

/// The stars of lines, then the others.
std::vector<std::optional<RuledStar>> ruledStars(const IrregularStars& stars) {
  const std::size_t lines = stars.lines().size();
  std::vector<std::optional<RuledStar>> result(lines + stars.others().size());
  parallelFor<std::size_t>(
      result.size(),
      [&](std::size_t k) {
        const LineStar* const line = k < lines ? &stars.lines()[k] : nullptr;
        result[k] = ruledStar(stars, line ? line->centre : stars.others()[k - lines], line);
      },
      16);
  return result;
}

/// May the child between an irregular vertex and this one be moved?
bool free(const IrregularStars& stars, Index vertex) {
  return stars.kind(vertex) != StarKind::Other && stars.kind(vertex) != StarKind::Wall;
}

/// What one irregular vertex asks of the children around it.
StarMoves claims(const IrregularStars& stars, const RuledStar& star) {
  if (!star.rule->moves) return {};
  const StarPaths paths(stars.complex(), star.vertices);
  if (!paths.unique()) return {};
  StarMoves result;
  for (std::size_t a = 1; a < star.vertices.size(); ++a) {
    const int label = static_cast<int>(a);
    if (free(stars, star.vertices[a])) result.add(paths, label, star.rule->moves->row(label));
  }
  return result;
}

}  // namespace

bool starFolds(const IrregularStars& stars, Index vertex) {
  const LineStar* line = nullptr;
  if (stars.kind(vertex) == StarKind::Line) {
    line = &stars.line(vertex);
  } else if (stars.kind(vertex) != StarKind::Other) {
    return false;
  }
  const auto star = ruledStar(stars, vertex, line);
  return star && star->rule->folds;
}

std::vector<StarLimit> interiorLimits(const Complex& complex) {
  std::vector<StarLimit> limits;
  if (!complex.coarse) return limits;
  const IrregularStars stars(complex);
  // Weights suppose that a star's own moves are made, and no others: its neighbours are plain, or
  // on a line that leads to its centre.
  const auto alone = [&](const std::vector<Index>& vertices) {
    return std::all_of(vertices.begin() + 1, vertices.end(), [&](Index v) {
      if (stars.kind(v) == StarKind::Plain) return true;
      if (stars.kind(v) != StarKind::Line) return false;
      const LineStar& line = stars.line(v);
      return line.up == vertices[0] || line.down == vertices[0];
    });
  };
  const auto add = [&](std::vector<Index> vertices,
                       std::shared_ptr<const Eigen::VectorXd> weights) {
    if (!alone(vertices) || !StarPaths(complex, vertices).unique()) return;
    limits.push_back({std::move(vertices), std::move(weights)});
  };
  for (auto& star : ruledStars(stars)) {
    if (star) add(std::move(star->vertices), {star->rule, &star->rule->limit});
  }
  static const auto twin = std::make_shared<const Eigen::VectorXd>(twinLimit());
  for (auto& vertices : twinStars(stars)) add(std::move(vertices), twin);
  return limits;
}

std::vector<StarMoves> interiorMoves(const IrregularStars& stars) {
  const auto ruled = ruledStars(stars);
  std::vector<StarMoves> claimed(ruled.size());
  parallelFor<std::size_t>(
      ruled.size(),
      [&](std::size_t k) {
        if (ruled[k]) claimed[k] = claims(stars, *ruled[k]);
      },
      16);
  return claimed;
}

}  // namespace octet
