// SPDX-License-Identifier: Apache-2.0
#include "subject.h"

#include <algorithm>
#include <memory>

#include <octet/core/topology/mean_edge.h>

#include "../vdb/vdb_sampler.h"

namespace octet {
namespace {

/// Levels are added while there are fewer cells than this.
constexpr double kAutomaticCells = 1e5;
/// More cells than this are refused, for memory.
constexpr double kMostCells = 2e7;

/// Cells of every level; a tetrahedron becomes four and an octahedron, an octahedron six and eight
/// tetrahedra.
double cellsAt(const Complex& control, int levels) {
  double tets = control.tetCount(), octs = control.octCount();
  for (int level = 0; level < levels; ++level) {
    const double coarse = tets;
    tets = 4 * tets + 8 * octs;
    octs = coarse + 6 * octs;
  }
  return tets + octs;
}

int chooseLevels(const Complex& control, const std::optional<int>& asked) {
  int levels = 0;
  if (!asked) {
    while (cellsAt(control, levels + 1) <= kAutomaticCells) ++levels;
    return levels;
  }
  if (*asked < 0 || *asked > kMaxLevels || cellsAt(control, *asked) > kMostCells) {
    while (cellsAt(control, levels + 1) <= kMostCells) ++levels;
    throw InputError("levels", std::to_string(*asked) + " is out of range; this asset takes 0 to " +
                                   std::to_string(levels));
  }
  return *asked;
}

const Form* chooseForm(const ControlAsset& asset, const std::string& name) {
  if (!name.empty()) return &asset.form(name);
  for (const int degree : {2, 1, 0, 3}) {
    for (const Form& form : asset.forms) {
      if (form.degree == degree) return &form;
    }
  }
  return nullptr;
}

template <int K>
void setField(const ControlAsset& asset, const Form& form, const Subdivision& subdivision,
              const AssetSubjectOptions& options, Subject* subject, const Context& context) {
  const auto field =
      makeField(subdivision, coefficients<K>(asset, form, options.frame),
                boundaryMode(asset, form, options.boundary), options.reconstruction, context);
  subject->components = kComponents<K>;
  subject->sample = [field](const Vec3& point, double* value) {
    typename Piece<kComponents<K>>::Value v;
    if (!field.sample(point, &v)) return false;
    std::copy(v.data(), v.data() + kComponents<K>, value);
    return true;
  };
}

/// Edge e of a level as a polyline of the finest level's vertices: halves of edge e are 2e and
/// 2e + 1 on the next level, in order (SCHEME.md section 3).
SubjectShape::Polyline refinedEdge(const Subdivision& refiner, int level, Index edge,
                                   const Array<Vec3>& positions) {
  const int steps = refiner.levels() - level;
  const Complex& finest = *refiner.finest();
  const Index first = edge << steps, count = Index{1} << steps;
  SubjectShape::Polyline line = {positions[finest.edges[first][0]]};
  for (Index k = first; k < first + count; ++k) line.push_back(positions[finest.edges[k][1]]);
  return line;
}

SubjectShape assetShape(const ControlAsset& asset, const Subdivision& refiner,
                        const Array<Vec3>& positions, int meshLevel) {
  SubjectShape shape;
  const Complex& control = *asset.mesh.complex();
  for (Index e = 0; e < control.edgeCount(); ++e) {
    const auto& [a, b] = control.edges[e];
    shape.cage.push_back({asset.mesh.positions()[a], asset.mesh.positions()[b]});
    shape.inner.push_back(!control.edgeOnBoundary(e));
  }
  const Complex& coarse = *refiner.complex(meshLevel);
  for (Index e = 0; e < coarse.edgeCount(); ++e) {
    if (coarse.edgeOnBoundary(e)) {
      shape.mesh.push_back(refinedEdge(refiner, meshLevel, e, positions));
    }
  }
  const Complex& finest = *refiner.finest();
  std::vector<Index> place(finest.vertexCount(), kNone);
  for (Index f = 0; f < finest.facetCount(); ++f) {
    if (!finest.facetOnBoundary(f)) continue;
    std::array<Index, 3> triangle = finest.facetVertices(f);
    for (Index& v : triangle) {
      if (place[v] == kNone) {
        place[v] = static_cast<Index>(shape.points.size());
        shape.points.push_back(positions[v]);
      }
      v = place[v];
    }
    shape.triangles.push_back(triangle);
  }
  return shape;
}

}  // namespace

Subject assetSubject(const ControlAsset& asset, const AssetSubjectOptions& options,
                     const Context& context) {
  const Form* form = chooseForm(asset, options.form);
  RefinerOptions refinement;
  refinement.levels = chooseLevels(*asset.mesh.complex(), options.levels);
  refinement.zeta = options.zeta;
  refinement.boundaryRows = options.wallSurface;
  const auto subdivision = options.boundary.subdivide(asset.mesh, refinement, context.sub(0.6));
  const Subdivision& refiner = *subdivision;
  const Array<Vec3>& positions = options.reconstruction == Reconstruction::Limit
                                     ? refiner.limitPositions(context.sub(0.1))
                                     : refiner.positions(refiner.levels());
  Subject subject;
  subject.source = asset.name;
  subject.upAxis = asset.units.upAxis;
  for (const Vec3& p : positions) subject.bounds.extend(p);
  subject.detail = meanEdge(*refiner.finest(), positions);
  subject.shape =
      assetShape(asset, refiner, positions, std::clamp(options.meshLevel, 0, refiner.levels()));
  if (!form) return subject;
  subject.form = form->name;
  subject.unit = form->unit;
  subject.degree = form->degree;
  switch (form->degree) {
    case 0:
      setField<0>(asset, *form, refiner, options, &subject, context);
      break;
    case 1:
      setField<1>(asset, *form, refiner, options, &subject, context);
      break;
    case 2:
      setField<2>(asset, *form, refiner, options, &subject, context);
      break;
    default:
      setField<3>(asset, *form, refiner, options, &subject, context);
  }
  return subject;
}

Subject vdbSubject(const std::string& path, const std::string& grid) {
  const VdbSampler sampler(path, grid);
  Subject subject;
  subject.source = sampler.name();
  subject.form = sampler.name();
  subject.unit = sampler.metadata("octet_unit");
  const std::string degree = sampler.metadata("octet_degree");
  if (degree.size() == 1 && degree[0] >= '0' && degree[0] <= '3') subject.degree = degree[0] - '0';
  subject.components = sampler.components();
  subject.bounds = sampler.bounds();
  subject.detail = sampler.voxelSize();
  subject.sample = [sampler](const Vec3& point, double* value) {
    return sampler.sample(point, value);
  };
  const Box& box = sampler.bounds();
  const auto corner = [&](int bits) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = bits >> k & 1 ? box.max[k] : box.min[k];
    return p;
  };
  for (int a = 0; a < 8; ++a) {
    for (int k = 0; k < 3; ++k) {
      if (a >> k & 1) continue;
      subject.shape.cage.push_back({corner(a), corner(a | 1 << k)});
      subject.shape.inner.push_back(false);
    }
  }
  return subject;
}

}  // namespace octet
