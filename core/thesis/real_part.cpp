// SPDX-License-Identifier: Apache-2.0
#include "real_part.h"

namespace octet {

RealPart RealPart::child(const RealPart& coarse, const Complex& own, const Complex& larger) {
  RealPart result;
  const ChildNumbering children = larger.children();
  const auto& cells = coarse.places[3];
  const auto firstOct = cells.begin() + own.tetCount();
  const std::vector<Index> tets(cells.begin(), firstOct);
  std::vector<Index> octs(firstOct, cells.end());
  for (Index& oct : octs) oct -= larger.tetCount();

  // Children of one kind after the other, `count` of each parent.
  const auto add = [](const std::vector<Index>& parents, int count, std::vector<Index>* places,
                      const auto& number) {
    for (const Index parent : parents) {
      for (int k = 0; k < count; ++k) places->push_back(number(parent, k));
    }
  };
  auto& vertices = result.places[0];
  vertices = coarse.places[0];
  add(coarse.places[1], 1, &vertices, [&](Index e, int) { return children.midpoint(e); });
  add(octs, 1, &vertices, [&](Index o, int) { return children.centre(o); });

  auto& edges = result.places[1];
  add(coarse.places[1], 2, &edges, [&](Index e, int k) { return children.half(e, k); });
  add(coarse.places[2], 3, &edges, [&](Index f, int k) { return children.cut(f, k); });
  add(octs, 12, &edges, [&](Index o, int k) { return children.spoke(o, k); });

  auto& facets = result.places[2];
  add(coarse.places[2], 4, &facets, [&](Index f, int k) { return children.onFacet(f, k); });
  add(tets, 4, &facets, [&](Index t, int k) { return children.inTet(t, k); });
  add(octs, 24, &facets, [&](Index o, int k) { return children.inOct(o, k); });

  auto& fine = result.places[3];
  add(tets, 4, &fine, [&](Index t, int k) { return children.cornerTet(t, k); });
  add(octs, 8, &fine, [&](Index o, int k) { return children.innerTet(o, k); });
  add(tets, 1, &fine, [&](Index t, int) { return children.innerOct(t); });
  add(octs, 6, &fine, [&](Index o, int k) { return children.cornerOct(o, k); });
  return result;
}

}  // namespace octet
