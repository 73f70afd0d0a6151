// SPDX-License-Identifier: Apache-2.0
#include "half_edges.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "../base/error.h"

namespace octet {
namespace {

/// A side of a triangle, by its sorted vertices.
struct Side {
  Index low, high, halfEdge;

  bool operator<(const Side& o) const {
    return std::tie(low, high, halfEdge) < std::tie(o.low, o.high, o.halfEdge);
  }
};

/// Sides of a surface's triangles: two in a row belong to one edge.
std::vector<Side> pairedSides(const TriangleSurface& surface) {
  std::vector<Side> sides;
  sides.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Index a = surface.triangles[t][k], b = surface.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(3 * t) + k});
    }
  }
  std::sort(sides.begin(), sides.end());
  const auto same = [&](std::size_t k, std::size_t l) {
    return sides[k].low == sides[l].low && sides[k].high == sides[l].high;
  };
  for (std::size_t k = 0; k < sides.size(); k += 2) {
    const bool pair = k + 1 < sides.size() && same(k, k + 1);
    if (pair && !(k + 2 < sides.size() && same(k, k + 2))) continue;
    throw InputError("triangles[" + std::to_string(sides[k].halfEdge / 3) + "]",
                     "edge (" + std::to_string(sides[k].low) + "," + std::to_string(sides[k].high) +
                         ") does not have two triangles");
  }
  return sides;
}

}  // namespace

HalfEdges::HalfEdges(const TriangleSurface& surface, const SharpEdges& sharp) {
  TriangleSurface turned = surface;
  orient(&turned);
  from_.resize(3 * turned.triangles.size());
  twin_.assign(from_.size(), kNone);
  chain_.assign(from_.size(), kNone);
  out_.assign(turned.vertices.size(), kNone);
  for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
    const auto& [a, b, c] = turned.triangles[t];
    set(static_cast<Index>(t), a, b, c);
  }
  const std::vector<Side> sides = pairedSides(turned);
  for (std::size_t k = 0, s = 0; k < sides.size(); k += 2) {
    const std::array<Index, 2> edge = {sides[k].low, sides[k].high};
    while (s < sharp.edges.size() && sharp.edges[s] < edge) ++s;
    const bool isSharp = s < sharp.edges.size() && sharp.edges[s] == edge;
    join(sides[k].halfEdge, sides[k + 1].halfEdge, isSharp ? sharp.chains[s] : kNone);
  }
  checkRings();
}

void HalfEdges::orient(TriangleSurface* surface) const {
  const std::vector<Side> sides = pairedSides(*surface);
  std::vector<Index> across(3 * surface->triangles.size());
  for (std::size_t k = 0; k < sides.size(); k += 2) {
    across[sides[k].halfEdge] = sides[k + 1].halfEdge;
    across[sides[k + 1].halfEdge] = sides[k].halfEdge;
  }
  const auto forward = [&](Index h) {
    const auto& t = surface->triangles[h / 3];
    return t[h % 3] < t[(h % 3 + 1) % 3];
  };
  std::vector<std::int8_t> turn(surface->triangles.size(), 0);  // 1: as it is, -1: reversed
  std::vector<Index> open;
  for (std::size_t first = 0; first < turn.size(); ++first) {
    if (turn[first] != 0) continue;
    turn[first] = 1;
    open.push_back(static_cast<Index>(first));
    while (!open.empty()) {
      const Index t = open.back();
      open.pop_back();
      for (Index h = 3 * t; h < 3 * t + 3; ++h) {
        const Index u = across[h] / 3;
        const auto wanted =
            static_cast<std::int8_t>(forward(h) != forward(across[h]) ? turn[t] : -turn[t]);
        if (turn[u] == 0) open.push_back(u);
        if (turn[u] == -wanted) {
          throw InputError("triangles[" + std::to_string(u) + "]", "the surface is one-sided");
        }
        turn[u] = wanted;
      }
    }
  }
  for (std::size_t t = 0; t < turn.size(); ++t) {
    if (turn[t] < 0) std::swap(surface->triangles[t][1], surface->triangles[t][2]);
  }
}

void HalfEdges::checkRings() const {
  std::vector<Index> uses(out_.size(), 0);
  for (const Index v : from_) ++uses[v];
  for (Index v = 0; v < vertexCount(); ++v) {
    if (hasVertex(v) && valence(v) != uses[v]) {
      throw InputError("vertices[" + std::to_string(v) + "]", "the surface touches itself here");
    }
  }
}

void HalfEdges::set(Index t, Index a, Index b, Index c) {
  const Index v[3] = {a, b, c};
  for (int k = 0; k < 3; ++k) {
    from_[3 * t + k] = v[k];
    out_[v[k]] = 3 * t + k;
  }
}

void HalfEdges::join(Index h, Index g, Index chain) {
  twin_[h] = g;
  twin_[g] = h;
  chain_[h] = chain_[g] = chain;
}

Index HalfEdges::valence(Index v) const {
  Index n = 0;
  visitRing(v, [&](Index) { ++n; });
  return n;
}

bool HalfEdges::neighbours(Index a, Index b) const {
  bool found = false;
  visitRing(a, [&](Index h) { found |= to(h) == b; });
  return found;
}

Index HalfEdges::split(Index h) {
  const Index g = twin_[h];
  const Index a = from(h), b = to(h), c = apex(h), d = apex(g), onChain = chain_[h];
  const Index ca = twin_[prev(h)], bc = twin_[next(h)], ad = twin_[next(g)], db = twin_[prev(g)];
  const Index m = vertexCount(), t = h / 3, u = g / 3, t2 = count() / 3, u2 = t2 + 1;
  out_.push_back(kNone);
  for (auto* list : {&from_, &twin_, &chain_}) list->resize(list->size() + 6, kNone);
  set(t, a, m, c);
  set(t2, m, b, c);
  set(u, b, m, d);
  set(u2, m, a, d);
  join(3 * t, 3 * u2, onChain);
  join(3 * t2, 3 * u, onChain);
  join(3 * t + 1, 3 * t2 + 2, kNone);
  join(3 * u + 1, 3 * u2 + 2, kNone);
  join(3 * t + 2, ca, chain_[ca]);
  join(3 * t2 + 1, bc, chain_[bc]);
  join(3 * u2 + 1, ad, chain_[ad]);
  join(3 * u + 2, db, chain_[db]);
  return m;
}

bool HalfEdges::canFlip(Index h) const {
  const Index c = apex(h), d = apex(twin_[h]);
  return chain_[h] == kNone && c != d && !neighbours(c, d) && valence(from(h)) > 3 &&
         valence(to(h)) > 3;
}

void HalfEdges::flip(Index h) {
  const Index g = twin_[h], t = h / 3, u = g / 3;
  const Index a = from(h), b = to(h), c = apex(h), d = apex(g);
  const Index ca = twin_[prev(h)], bc = twin_[next(h)], ad = twin_[next(g)], db = twin_[prev(g)];
  set(t, a, d, c);
  set(u, d, b, c);
  join(3 * t + 1, 3 * u + 2, kNone);
  join(3 * t, ad, chain_[ad]);
  join(3 * t + 2, ca, chain_[ca]);
  join(3 * u, db, chain_[db]);
  join(3 * u + 1, bc, chain_[bc]);
}

bool HalfEdges::canCollapse(Index h) const {
  const Index g = twin_[h], a = from(h), b = to(h), c = apex(h), d = apex(g);
  if (c == d || valence(c) <= 3 || valence(d) <= 3) return false;
  // The edges that merge may not both be sharp.
  if (chain_[next(h)] != kNone && chain_[prev(h)] != kNone) return false;
  if (chain_[next(g)] != kNone && chain_[prev(g)] != kNone) return false;
  Index common = 0;
  visitRing(a, [&](Index k) { common += neighbours(b, to(k)); });
  return common == 2;
}

void HalfEdges::collapse(Index h) {
  const Index g = twin_[h], a = from(h), b = to(h), c = apex(h), d = apex(g);
  const Index ca = twin_[prev(h)], bc = twin_[next(h)], ad = twin_[next(g)], db = twin_[prev(g)];
  std::vector<Index> ring;
  visitRing(a, [&](Index k) { ring.push_back(k); });
  for (const Index k : ring) from_[k] = b;
  join(ca, bc, std::max(chain_[ca], chain_[bc]));
  join(ad, db, std::max(chain_[ad], chain_[db]));
  for (const Index dead : {h / 3, g / 3}) {
    for (int k = 0; k < 3; ++k) from_[3 * dead + k] = kNone;
  }
  out_[a] = kNone;
  out_[b] = ca;  // from a to c, now from b
  out_[c] = bc;
  out_[d] = ad;
}

TriangleSurface HalfEdges::surface(const std::vector<Vec3>& positions,
                                   std::vector<std::array<Index, 2>>* edges) const {
  TriangleSurface result;
  std::vector<Index> number(out_.size(), kNone);
  for (Index v = 0; v < vertexCount(); ++v) {
    if (!hasVertex(v)) continue;
    number[v] = static_cast<Index>(result.vertices.size());
    result.vertices.push_back(positions[v]);
  }
  for (Index h = 0; h < count(); h += 3) {
    if (!alive(h)) continue;
    result.triangles.push_back({number[from_[h]], number[from_[h + 1]], number[from_[h + 2]]});
  }
  edges->clear();
  for (Index h = 0; h < count(); ++h) {
    if (!alive(h) || chain_[h] == kNone || h > twin_[h]) continue;
    const Index a = number[from(h)], b = number[to(h)];
    edges->push_back({std::min(a, b), std::max(a, b)});
  }
  std::sort(edges->begin(), edges->end());
  return result;
}

}  // namespace octet
