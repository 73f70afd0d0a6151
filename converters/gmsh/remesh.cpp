// SPDX-License-Identifier: Apache-2.0
#include "remesh.h"

#include <algorithm>

#include <octet/core/base/error.h>

#include "gmsh_program.h"

namespace octet {
namespace {

using namespace gmsh_import;

GmshWork cgalWork(MessageKind request, const TriangleSurface& surface, const char* doing) {
  GmshWork work;
  work.request = request;
  work.who = "CGAL";
  work.doing = doing;
  work.content = pack(SurfaceRequest{surface, 0, 0});
  return work;
}

/// What came back is another process' word.
void checkIndices(const TriangleSurface& surface) {
  const auto count = static_cast<Index>(surface.vertices.size());
  for (const auto& triangle : surface.triangles) {
    for (const Index v : triangle) {
      if (v < 0 || v >= count) throw InputError("", "CGAL failed: a triangle has no such vertex");
    }
  }
}

void checkIndices(const RemeshedSurface& remeshed) {
  checkIndices(remeshed.surface);
  const auto count = static_cast<Index>(remeshed.surface.vertices.size());
  const auto bad = [&](Index v) { return v < 0 || v >= count; };
  bool any = std::any_of(remeshed.corners.begin(), remeshed.corners.end(), bad);
  for (const auto& [a, b] : remeshed.creases) any = any || bad(a) || bad(b);
  if (any) throw InputError("", "CGAL failed: a crease has no such vertex");
}

template <typename Result>
Result ask(const GmshWork& work, const Context& context) {
  auto result = askGmsh<Result>(work, context);
  checkIndices(result);
  return result;
}

}  // namespace

TriangleSurface oriented(const TriangleSurface& surface, const Context& context) {
  return ask<TriangleSurface>(cgalWork(MessageKind::Orient, surface, "orienting it"), context);
}

RemeshedSurface remesh(const TriangleSurface& surface, const RemeshOptions& options,
                       const Context& context) {
  GmshWork work = cgalWork(MessageKind::Remesh, surface, "remeshing it");
  work.content = pack(SurfaceRequest{surface, options.edgeLength, options.sharpAngle});
  work.report = {"remesh surface", 0, 0, "rounds"};
  return ask<RemeshedSurface>(work, context);
}

TriangleSurface withoutSlivers(const TriangleSurface& surface, const Context& context) {
  GmshWork work = cgalWork(MessageKind::Clean, surface, "cleaning it");
  work.report = {"check surface", 0, 1, "surface"};
  return ask<TriangleSurface>(work, context);
}

}  // namespace octet
