// SPDX-License-Identifier: Apache-2.0
#include "nesting.h"

#include <algorithm>
#include <map>

namespace octet {
namespace {

/// Parts of a surface joined by vertices: each triangle's part, numbered from 0.
std::vector<Index> partsOf(const TriangleSurface& surface, Index* count) {
  std::vector<Index> parent(surface.vertices.size());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<Index>(v);
  const auto root = [&](Index v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : surface.triangles) {
    for (const Index v : t) parent[root(v)] = root(t[0]);
  }
  std::map<Index, Index> numbers;
  std::vector<Index> parts;
  parts.reserve(surface.triangles.size());
  for (const auto& t : surface.triangles) {
    parts.push_back(numbers.emplace(root(t[0]), static_cast<Index>(numbers.size())).first->second);
  }
  *count = static_cast<Index>(numbers.size());
  return parts;
}

/// Does a ray from `p` along +x cross the triangle? Edges count for one of their two sides only, by
/// half-open comparisons that both triangles at an edge make alike, so that parity is exact.
bool rayCrosses(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  bool inside = false;
  const Vec3* corners[3] = {&a, &b, &c};
  for (int k = 0; k < 3; ++k) {
    const Vec3 *from = corners[k], *to = corners[(k + 1) % 3];
    if (((*from)[1] > p[1]) == ((*to)[1] > p[1])) continue;
    if ((*from)[1] > (*to)[1]) std::swap(from, to);  // the same arithmetic from both triangles
    const double t = (p[1] - (*from)[1]) / ((*to)[1] - (*from)[1]);
    if ((*from)[2] + t * ((*to)[2] - (*from)[2]) > p[2]) inside = !inside;
  }
  if (!inside) return false;
  const Vec3 normal = (b - a).cross(c - a);
  return normal[0] != 0 && (a - p).dot(normal) / normal[0] > 0;
}

}  // namespace

std::vector<SurfacePart> surfaceParts(const TriangleSurface& surface) {
  Index count = 0;
  const std::vector<Index> partOf = partsOf(surface, &count);
  std::vector<SurfacePart> parts(count);
  std::vector<Box> boxes(surface.triangles.size());
  const Vec3 origin = surface.vertices.empty() ? Vec3::Zero() : Vec3(surface.vertices[0]);
  for (std::size_t t = 0; t < partOf.size(); ++t) {
    const auto& [a, b, c] = surface.triangles[t];
    const Vec3 p = surface.vertices[a], q = surface.vertices[b], r = surface.vertices[c];
    for (const Vec3& x : {p, q, r}) boxes[t].extend(x);
    SurfacePart& part = parts[partOf[t]];
    part.triangles.push_back(static_cast<Index>(t));
    part.volume += (p - origin).dot((q - origin).cross(r - origin)) / 6;
  }
  const double end = surface.bounds().max[0];
  const BoxTree tree(std::move(boxes));
  const auto corner = [&](Index t, int k) -> const Vec3& {
    return surface.vertices[surface.triangles[t][k]];
  };
  std::vector<std::vector<Index>> enclosing(count);
  for (Index part = 0; part < count; ++part) {
    const Index sample = parts[part].triangles[0];
    const Vec3 p = (corner(sample, 0) + corner(sample, 1) + corner(sample, 2)) / 3;
    Box ray;
    ray.extend(p);
    ray.extend(Vec3(end, p[1], p[2]));
    std::map<Index, int> crossings;
    tree.visitTouching(ray, [&](Index t) {
      if (partOf[t] != part && rayCrosses(p, corner(t, 0), corner(t, 1), corner(t, 2))) {
        ++crossings[partOf[t]];
      }
    });
    for (const auto& [other, n] : crossings) {
      if (n % 2) enclosing[part].push_back(other);
    }
    parts[part].depth = static_cast<Index>(enclosing[part].size());
    parts[part].volume = std::abs(parts[part].volume);
  }
  for (Index part = 0; part < count; ++part) {
    for (const Index other : enclosing[part]) {
      if (parts[other].depth == parts[part].depth - 1) parts[part].parent = other;
    }
  }
  return parts;
}

std::vector<SurfaceLayer> nestingLayers(const TriangleSurface& surface) {
  std::vector<SurfaceLayer> layers;
  std::vector<std::vector<Index>> triangles;  // of each layer
  for (const SurfacePart& part : surfaceParts(surface)) {
    const auto depth = static_cast<std::size_t>(part.depth);
    if (layers.size() <= depth) {
      layers.resize(depth + 1);
      triangles.resize(depth + 1);
    }
    layers[depth].volume += part.volume;
    ++layers[depth].parts;
    auto& list = triangles[depth];
    list.insert(list.end(), part.triangles.begin(), part.triangles.end());
  }
  for (std::size_t depth = 0; depth < layers.size(); ++depth) {
    std::sort(triangles[depth].begin(), triangles[depth].end());
    TriangleSurface& layer = layers[depth].surface;
    for (const Index t : triangles[depth]) layer.triangles.push_back(surface.triangles[t]);
    layer.vertices = surface.vertices;
    layer = welded(layer);
  }
  return layers;
}

}  // namespace octet
