// SPDX-License-Identifier: Apache-2.0
#include "irregular_stars.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <tuple>

#include "../base/parallel.h"
#include "../rules/interior_rules.h"

namespace octet {
namespace {

/// @brief The cells at a vertex, read by vertices.
class CellsAt {
 public:
  CellsAt(const Complex& complex, Index centre) : c_(complex), centre_(centre) {
    c_.visitVertexStar(centre, [&](const CellAtVertex& at) { cells_.push_back(at.cell); });
  }

  const std::vector<Index>& cells() const { return cells_; }
  std::vector<Index> with(Index vertex) const {
    std::vector<Index> found;
    for (const Index cell : cells_) {
      if (place(cell, vertex) >= 0) found.push_back(cell);
    }
    return found;
  }
  bool has(Index cell, Index vertex) const { return place(cell, vertex) >= 0; }
  bool isTet(Index cell) const { return c_.isTet(cell); }
  std::vector<Index> vertices(Index cell) const {
    std::vector<Index> list;
    for (int k = 0; k < c_.cellVertexCount(cell); ++k) list.push_back(c_.cellVertex(cell, k));
    return list;
  }
  /// The vertex opposite another in an octahedron.
  Index opposite(Index oct, Index vertex) const {
    return c_.cellVertex(oct, Octahedron::opposite[place(oct, vertex)]);
  }
  /// The two vertices w of a cell for which (centre, a, w) is one of its facets, ascending.
  std::pair<Index, Index> beside(Index cell, Index a) const {
    std::pair<Index, Index> two{kNone, kNone};
    for (const Index w : vertices(cell)) {
      if (w == centre_ || w == a) continue;
      if (!isTet(cell)) {
        const Index far = opposite(cell, w);
        if (far == centre_ || far == a) continue;
      }
      (two.first == kNone ? two.first : two.second) = w;
    }
    if (two.first > two.second) std::swap(two.first, two.second);
    return two;
  }
  /// Is (centre, a, b) a facet?
  bool facet(Index a, Index b) const {
    return std::any_of(cells_.begin(), cells_.end(), [&](Index cell) {
      if (!has(cell, a) || !has(cell, b)) return false;
      return isTet(cell) || (opposite(cell, a) != b && opposite(cell, a) != centre_ &&
                             opposite(cell, b) != centre_);
    });
  }

 private:
  int place(Index cell, Index vertex) const {
    for (int k = 0; k < c_.cellVertexCount(cell); ++k) {
      if (c_.cellVertex(cell, k) == vertex) return k;
    }
    return -1;
  }

  const Complex& c_;
  Index centre_;
  std::vector<Index> cells_;
};

/// @brief Builds the reflection of a star that exchanges two vertices a and b, if it has one.
class Reflection {
 public:
  Reflection(const CellsAt& star, Index centre, Index a, Index b)
      : star_(star), upper_(star.with(a)), lower_(star.with(b)), a_(a), b_(b) {
    image_ = {{centre, centre}, {a, b}, {b, a}};
  }

  std::optional<std::map<Index, Index>> find() {
    constexpr std::size_t kFewestCells = 3;
    if (upper_.size() < kFewestCells) return std::nullopt;
    for (const Index cell : upper_) {
      if (star_.has(cell, b_)) return std::nullopt;
    }
    if (!matchRings() || !matchCells()) return std::nullopt;
    for (const Index cell : star_.cells()) {
      for (const Index v : star_.vertices(cell)) image_.emplace(v, v);
    }
    return keepsCells() ? std::make_optional(image_) : std::nullopt;
  }

 private:
  std::vector<Index> ring(const std::vector<Index>& cells, Index axis) const {
    std::vector<Index> list;
    for (const Index cell : cells) {
      const auto [v, w] = star_.beside(cell, axis);
      list.push_back(v);
      list.push_back(w);
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    return list;
  }

  /// r <-> s where (m, r, s) is a facet.
  bool matchRings() {
    const std::vector<Index> above = ring(upper_, a_), below = ring(lower_, b_);
    for (const Index r : above) {
      if (std::binary_search(below.begin(), below.end(), r)) return false;
    }
    for (const Index r : above) {
      Index match = kNone;
      for (const Index s : below) {
        if (!star_.facet(r, s)) continue;
        if (match != kNone) return false;
        match = s;
      }
      if (match == kNone) return false;
      image_[r] = match;
      image_[match] = r;
    }
    return true;
  }

  /// Cells above go to cells below, and what lies opposite m in them likewise.
  bool matchCells() {
    const Index centre = star_.cells().empty() ? kNone : centreOf();
    for (const Index cell : upper_) {
      auto [v, w] = star_.beside(cell, a_);
      std::pair<Index, Index> wanted = std::minmax(image_[v], image_[w]);
      Index match = kNone;
      for (const Index other : lower_) {
        if (star_.isTet(other) != star_.isTet(cell) || star_.beside(other, b_) != wanted) continue;
        if (match != kNone) return false;
        match = other;
      }
      if (match == kNone) return false;
      if (star_.isTet(cell)) continue;
      const Index far = star_.opposite(cell, centre), near = star_.opposite(match, centre);
      image_[far] = near;
      image_[near] = far;
    }
    return true;
  }

  Index centreOf() const {
    for (const auto& [v, w] : image_) {
      if (v == w) return v;
    }
    return kNone;
  }

  bool keepsCells() const {
    for (const auto& [v, w] : image_) {
      if (image_.at(w) != v) return false;
    }
    std::vector<std::vector<Index>> own, images;
    for (const Index cell : star_.cells()) {
      std::vector<Index> vertices = star_.vertices(cell), mapped;
      for (const Index v : vertices) mapped.push_back(image_.at(v));
      std::sort(vertices.begin(), vertices.end());
      std::sort(mapped.begin(), mapped.end());
      own.push_back(std::move(vertices));
      images.push_back(std::move(mapped));
    }
    std::sort(own.begin(), own.end());
    std::sort(images.begin(), images.end());
    return own == images;
  }

  const CellsAt& star_;
  std::vector<Index> upper_, lower_;
  Index a_, b_;
  std::map<Index, Index> image_;
};

std::vector<Index> irregularEdges(const Complex& complex) {
  std::vector<Index> list;
  for (Index e = 0; e < complex.edgeCount(); ++e) {
    if (complex.edgeOnBoundary(e)) continue;
    // Edges made inside control facets and cells have two tetrahedra and two octahedra.
    if (complex.coarse && !(complex.edgeFlags[e] & kOnControlEdge)) continue;
    int tets = 0, octs = 0;
    complex.visitEdgeStar(e,
                          [&](const CellAtEdge& at) { ++(complex.isTet(at.cell) ? tets : octs); });
    if (tets != 2 || octs != 2) list.push_back(e);
  }
  return list;
}

/// Solves the rule of a star, or finds it among those solved before.
std::shared_ptr<const InteriorRule> ruleOf(const InteriorStar& star) {
  using Rule = std::shared_ptr<const InteriorRule>;
  static std::mutex mutex;
  static std::map<InteriorStar, Rule> solved;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    const auto found = solved.find(star);
    if (found != solved.end()) return found->second;
  }
  auto rule = std::make_shared<const InteriorRule>(interiorRule(star));
  const std::lock_guard<std::mutex> lock(mutex);
  return solved.emplace(star, std::move(rule)).first->second;
}

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

/// @brief What one irregular vertex asks of the children around it.
class Claims {
 public:
  explicit Claims(const IrregularStars& stars) : stars_(stars), c_(stars.complex()) {}

  std::vector<VertexMove> ofLine(const LineStar& line) const {
    const LineNames names = stars_.names(line);
    constexpr int kFewestTetrahedra = 3;
    if (names.size() < kFewestTetrahedra) return assigned(line.centre, &line);
    return closedForm(names);
  }
  std::vector<VertexMove> ofOther(Index centre) const { return assigned(centre, nullptr); }

 private:
  /// May the child between an irregular vertex and this one be moved?
  bool free(Index vertex) const {
    return stars_.kind(vertex) != StarKind::Other && stars_.kind(vertex) != StarKind::Wall;
  }

  std::vector<VertexMove> closedForm(const LineNames& names) const {
    const int n = names.size();
    const StarPaths paths(c_, {names.list(), {}});
    if (!paths.unique()) return {};
    const LineMoves moves = lineMoves(n);
    std::vector<VertexMove> result;
    const int upper = 3, lower = 3 + n, beyond = 3 + 2 * n;  // labels in the list of names
    for (const int side : {upper, lower}) {
      for (int i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (!free(side == upper ? names.upper[at] : names.lower[at])) continue;
        Eigen::VectorXd weights = Eigen::VectorXd::Zero(3 + 3 * n);
        for (int j = 0; j < n; ++j) {
          const auto step = static_cast<std::size_t>((j - i + n) % n);
          weights[upper + j] = weights[lower + j] = moves.ring[step];
          weights[beyond + j] = moves.beyond[step];
        }
        addMoves(paths, side + i, weights, &result);
      }
    }
    return result;
  }

  std::vector<VertexMove> assigned(Index centre, const LineStar* line) const {
    const auto labelled = InteriorLabels(c_, centre, line).canonical();
    if (!labelled) return {};
    const StarPaths paths(c_, {labelled->vertices, labelled->interior.star});
    if (!paths.unique()) return {};
    const auto rule = ruleOf(labelled->interior);
    if (!rule->moves) return {};
    std::vector<VertexMove> result;
    for (int a = 1; a < labelled->interior.star.vertexCount; ++a) {
      const Index vertex = labelled->vertices[static_cast<std::size_t>(a)];
      if (free(vertex)) addMoves(paths, a, rule->moves->row(a), &result);
    }
    return result;
  }

  const IrregularStars& stars_;
  const Complex& c_;
};

}  // namespace

Index LineStar::imageOf(Index vertex) const {
  const auto found = std::lower_bound(mirror.begin(), mirror.end(), std::pair{vertex, kNone});
  return found != mirror.end() && found->first == vertex ? found->second : vertex;
}

std::vector<Index> LineNames::list() const {
  std::vector<Index> all{centre, up, down};
  for (const auto* part : {&upper, &lower, &beyond})
    all.insert(all.end(), part->begin(), part->end());
  return all;
}

IrregularStars::IrregularStars(const Complex& complex) : c_(complex) {
  kinds_.resize(static_cast<std::size_t>(c_.vertexCount()));
  parallelFor<Index>(c_.vertexCount(), [&](Index v) {
    kinds_[v] = c_.vertexOnBoundary(v) ? StarKind::Wall : StarKind::Plain;
  });
  std::vector<std::pair<Index, Index>> ends;  // vertex and the other end of an irregular edge
  for (const Index e : irregularEdges(c_)) {
    const auto [a, b] = c_.edges[e];
    if (!c_.vertexOnBoundary(a)) ends.emplace_back(a, b);
    if (!c_.vertexOnBoundary(b)) ends.emplace_back(b, a);
  }
  std::sort(ends.begin(), ends.end());
  for (std::size_t k = 0; k < ends.size();) {
    std::size_t end = k;
    while (end < ends.size() && ends[end].first == ends[k].first) ++end;
    const Index v = ends[k].first;
    std::optional<std::map<Index, Index>> mirror;
    if (end - k == 2) {
      mirror = Reflection(CellsAt(c_, v), v, ends[k].second, ends[k + 1].second).find();
    }
    kinds_[v] = mirror ? StarKind::Line : StarKind::Other;
    if (mirror) {
      lines_.push_back({v, ends[k].second, ends[k + 1].second, {mirror->begin(), mirror->end()}});
    } else {
      others_.push_back(v);
    }
    k = end;
  }
}

LineNames IrregularStars::names(const LineStar& line) const {
  const CellsAt star(c_, line.centre);
  LineNames names{line.centre, line.up, line.down, {}, {}, {}};
  const LineNames none = names;
  std::vector<std::pair<Index, Index>> pairs;
  for (const Index cell : star.with(line.up)) {
    if (!star.isTet(cell)) return none;
    pairs.push_back(star.beside(cell, line.up));
  }
  names.upper = {pairs[0].first, pairs[0].second};
  while (names.upper.size() < pairs.size()) {
    const Index last = names.upper.back(), before = names.upper[names.upper.size() - 2];
    const auto next = std::find_if(pairs.begin(), pairs.end(), [&](const auto& p) {
      return (p.first == last && p.second != before) || (p.second == last && p.first != before);
    });
    if (next == pairs.end()) return none;
    names.upper.push_back(next->first == last ? next->second : next->first);
  }
  const std::size_t n = names.upper.size();
  for (std::size_t j = 0; j < n; ++j) {
    Index beyond = kNone;
    for (const Index cell : star.cells()) {
      if (star.isTet(cell) || !star.has(cell, names.upper[j]) ||
          !star.has(cell, names.upper[(j + 1) % n])) {
        continue;
      }
      if (beyond != kNone) return none;
      beyond = star.opposite(cell, line.centre);
    }
    if (beyond == kNone) return none;
    names.lower.push_back(line.imageOf(names.upper[j]));
    names.beyond.push_back(beyond);
  }
  std::vector<Index> all = names.list();
  std::sort(all.begin(), all.end());
  return std::adjacent_find(all.begin(), all.end()) == all.end() ? names : none;
}

namespace {

/// Puts rows in order and adds what one coarse edge has in a row, by size: sums then depend on
/// nothing but what is added.
void mergeMoves(std::vector<VertexMove>* moves) {
  const auto row = [](const VertexMove& m) { return std::pair(m.fineVertex, m.coarseEdge); };
  const auto signless = [](const VertexMove& m) { return std::abs(m.weight); };
  std::sort(moves->begin(), moves->end(), [&](const VertexMove& a, const VertexMove& b) {
    return std::tuple(row(a), signless(a), a.weight) < std::tuple(row(b), signless(b), b.weight);
  });
  std::size_t kept = 0;
  for (const VertexMove& move : *moves) {
    if (kept > 0 && row((*moves)[kept - 1]) == row(move)) {
      (*moves)[kept - 1].weight += move.weight;
    } else {
      (*moves)[kept++] = move;
    }
  }
  moves->resize(kept);
}

}  // namespace

bool starFolds(const IrregularStars& stars, Index vertex) {
  const LineStar* line = nullptr;
  if (stars.kind(vertex) == StarKind::Line) {
    const auto& lines = stars.lines();
    line = &*std::lower_bound(lines.begin(), lines.end(), vertex,
                              [](const LineStar& l, Index v) { return l.centre < v; });
    if (stars.names(*line).size() > 0) return false;  // tetrahedra only
  } else if (stars.kind(vertex) != StarKind::Other) {
    return false;
  }
  const auto labelled = InteriorLabels(stars.complex(), vertex, line).canonical();
  return labelled && ruleOf(labelled->interior)->folds;
}

std::vector<VertexMove> interiorMoves(const IrregularStars& stars) {
  const Claims claims(stars);
  const std::size_t lines = stars.lines().size();
  std::vector<std::vector<VertexMove>> claimed(lines + stars.others().size());
  parallelFor<std::size_t>(
      claimed.size(),
      [&](std::size_t k) {
        claimed[k] =
            k < lines ? claims.ofLine(stars.lines()[k]) : claims.ofOther(stars.others()[k - lines]);
      },
      16);
  std::vector<VertexMove> moves;
  for (auto& part : claimed) {
    mergeMoves(&part);
    moves.insert(moves.end(), part.begin(), part.end());
  }
  mergeMoves(&moves);
  return moves;
}

}  // namespace octet
