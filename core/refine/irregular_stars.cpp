// SPDX-License-Identifier: Apache-2.0
#include "irregular_stars.h"

#include <algorithm>

#include "../base/parallel.h"
#include "cells_at.h"
#include "star_reflection.h"

namespace octet {
namespace {

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
    std::optional<std::vector<std::pair<Index, Index>>> mirror;
    if (end - k == 2) mirror = starReflection(c_, v, ends[k].second, ends[k + 1].second);
    kinds_[v] = mirror ? StarKind::Line : StarKind::Other;
    if (mirror) {
      lines_.push_back({v, ends[k].second, ends[k + 1].second, std::move(*mirror)});
    } else {
      others_.push_back(v);
    }
    k = end;
  }
}

const LineStar& IrregularStars::line(Index vertex) const {
  return *std::lower_bound(lines_.begin(), lines_.end(), vertex,
                           [](const LineStar& line, Index v) { return line.centre < v; });
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

}  // namespace octet
