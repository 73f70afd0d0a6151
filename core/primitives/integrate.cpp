// SPDX-License-Identifier: Apache-2.0
#include "integrate.h"

#include <algorithm>
#include <cmath>

#include "../base/error.h"
#include "../base/reported_loop.h"
#include "../forms/coboundary.h"
#include "segment_integrals.h"

namespace octet {
namespace {

/// Simplices between two progress reports.
constexpr Index kChunk = 1 << 16;

class Integrator {
 public:
  Integrator(const Complex& complex, const Array<Vec3>& positions, const Context& context,
             std::string stage)
      : c_(complex), x_(positions), context_(context), stage_(std::move(stage)) {}

  template <typename Field>
  Cochain<1> circulations(const Field& field) const {
    return alongEdges([&](const Vec3& a, const Vec3& b) { return velocityAlong(field, a, b); });
  }
  Cochain<1> circulations(const CurlNoise& noise) const { return circulations(makeWaves(noise)); }
  Cochain<1> circulations(const VortexRing& ring) const {
    if (ring.core == 0) {
      throw InputError(nameOf(ring),
                       "needs a core for a 1-form: without one, circulations of edges near the "
                       "ring are not finite");
    }
    return alongEdges([&](const Vec3& a, const Vec3& b) { return velocityAlong(ring, a, b); });
  }
  Cochain<1> circulations(const PointSource& source) const {
    Cochain<0> potential(c_);
    for (Index v = 0; v < c_.vertexCount(); ++v) {
      potential[v] = potentialAt(source, x_[v]);
      if (!std::isfinite(potential[v])) {
        throw InputError(nameOf(source), "lies on vertex " + std::to_string(v) +
                                             " and has no core: the potential there is infinite");
      }
    }
    return d(c_, potential);
  }

  template <typename Field>
  Cochain<2> fluxes(const Field& field) const {
    const auto potential = [&](const Vec3& a, const Vec3& b) {
      return potentialAlong(field, a, b);
    };
    return d(c_, alongEdges(potential));
  }
  Cochain<2> fluxes(const CurlNoise& noise) const { return fluxes(makeWaves(noise)); }
  Cochain<2> fluxes(const PointSource& source) const {
    Cochain<2> result(c_);
    inChunks(c_.facetCount(), "facets", [&](Index f) {
      const auto [a, b, c] = c_.facetVertices(f);
      result[f] = fluxThrough(source, x_[a], x_[b], x_[c]);
    });
    return result;
  }

 private:
  template <typename Along>
  Cochain<1> alongEdges(const Along& along) const {
    Cochain<1> result(c_);
    inChunks(c_.edgeCount(), "edges",
             [&](Index e) { result[e] = along(x_[c_.edges[e][0]], x_[c_.edges[e][1]]); });
    return result;
  }

  template <typename Body>
  void inChunks(Index count, const char* unit, const Body& body) const {
    for (Index first = 0; first < count; first += kChunk) {
      context_.report(
          {stage_, static_cast<std::size_t>(first), static_cast<std::size_t>(count), unit});
      parallelFor<Index>(
          std::min(kChunk, count - first), [&](Index k) { body(first + k); }, context_, 64);
    }
  }

  const Complex& c_;
  const Array<Vec3>& x_;
  const Context& context_;
  std::string stage_;
};

}  // namespace

template <int K>
Cochain<K> integrate(const Primitive& primitive, const Complex& complex,
                     const Array<Vec3>& positions, const Context& context) {
  static_assert(K == 1 || K == 2, "velocities are 1-forms or 2-forms");
  checkPrimitive(primitive);
  const Integrator integrator(complex, positions, context, "add " + nameOf(primitive));
  return std::visit(
      [&](const auto& p) -> Cochain<K> {
        if constexpr (K == 1) {
          return integrator.circulations(p);
        } else {
          return integrator.fluxes(p);
        }
      },
      primitive);
}

template Cochain<1> integrate<1>(const Primitive&, const Complex&, const Array<Vec3>&,
                                 const Context&);
template Cochain<2> integrate<2>(const Primitive&, const Complex&, const Array<Vec3>&,
                                 const Context&);

}  // namespace octet
