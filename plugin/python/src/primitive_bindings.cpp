// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include <octet/core/base/error.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/primitives/integrate.h>

#include "arrays.h"
#include "bindings.h"
#include "long_call.h"

namespace octet::python {
namespace {

Vec3 vector(const py::object& object, const char* name) {
  const auto numbers = finiteNumbers(object, name, 3);
  return Vec3(numbers.at(0), numbers.at(1), numbers.at(2));
}

/// A primitive that can be.
template <typename T>
T checked(T primitive) {
  checkPrimitive(primitive);
  return primitive;
}

py::array integrals(const Primitive& primitive, const ControlMesh& mesh, int degree,
                    const py::object& progress) {
  const Context context = contextOf(progress);
  const auto with = [&](auto constant) {
    auto form = withoutGil([&] {
      return integrate<decltype(constant)::value>(primitive, *mesh.complex(), mesh.positions(),
                                                  context);
    });
    return handOver(std::move(form.values()));
  };
  if (degree == 1) return with(std::integral_constant<int, 1>{});
  if (degree == 2) return with(std::integral_constant<int, 2>{});
  throw InputError("degree", std::to_string(degree) + " is neither 1 nor 2");
}

py::array closest(const ControlMesh& mesh, int degree, const py::object& coefficients,
                  const py::object& zero) {
  const auto with = [&](auto constant) {
    constexpr int K = decltype(constant)::value;
    const Complex& c = *mesh.complex();
    const auto numbers = finiteNumbers(coefficients, "coefficients", c.count(K));
    const Cochain<K> form(Array<double>(numbers.data(), numbers.data() + numbers.size()));
    std::vector<std::uint8_t> fixed(static_cast<std::size_t>(c.count(K)), 0);
    if (!zero.is_none()) {
      const auto list = indexRows(zero, "zero", 0);
      for (py::ssize_t k = 0; k < list.size(); ++k) {
        const Index i = list.at(k);
        if (i >= c.count(K)) {
          throw InputError("zero[" + std::to_string(k) + "]",
                           "index " + std::to_string(i) + " is out of range");
        }
        fixed[static_cast<std::size_t>(i)] = 1;
      }
    }
    auto result = withoutGil([&] {
      return ClosedProjection<K>(c, mesh.positions(), fixed).apply(form, /*fixedToZero=*/true);
    });
    return handOver(std::move(result.values()));
  };
  if (degree == 1) return with(std::integral_constant<int, 1>{});
  if (degree == 2) return with(std::integral_constant<int, 2>{});
  throw InputError("degree", std::to_string(degree) + " is neither 1 nor 2");
}

void bindTurning(py::module_& module) {
  py::class_<UniformFlow>(module, "UniformFlow", py::module_local(),
                          "The same velocity everywhere, float (3,).")
      .def(py::init([](const py::object& velocity) {
             return checked(UniformFlow{vector(velocity, "velocity")});
           }),
           py::arg("velocity"));
  py::class_<RigidRotation>(module, "RigidRotation", py::module_local(),
                            "Turns like a rigid body; angular velocity in radians per second.")
      .def(py::init([](const py::object& centre, const py::object& angularVelocity) {
             return checked(RigidRotation{vector(centre, "centre"),
                                          vector(angularVelocity, "angular_velocity")});
           }),
           py::arg("centre"), py::arg("angular_velocity"));
  py::class_<VortexLine>(module, "VortexLine", py::module_local(),
                         R"(An endless straight vortex, turning like 1/r outside its core.

point, direction: float (3,); circulation: world units squared per second; core: a radius)")
      .def(py::init([](const py::object& point, const py::object& direction, double circulation,
                       double core) {
             return checked(VortexLine{vector(point, "point"), vector(direction, "direction"),
                                       circulation, core});
           }),
           py::arg("point"), py::arg("direction"), py::arg("circulation"), py::arg("core") = 0.0);
  py::class_<VortexRing>(module, "VortexRing", py::module_local(),
                         R"(A circular vortex; the flow passes through it along the normal.

centre, normal: float (3,); circulation: world units squared per second; core: a radius)")
      .def(py::init([](const py::object& centre, const py::object& normal, double radius,
                       double circulation, double core) {
             return checked(VortexRing{vector(centre, "centre"), vector(normal, "normal"), radius,
                                       circulation, core});
           }),
           py::arg("centre"), py::arg("normal"), py::arg("radius"), py::arg("circulation"),
           py::arg("core") = 0.0);
}

void bindOthers(py::module_& module) {
  py::class_<PointSource>(module, "PointSource", py::module_local(),
                          "A source, or sink: volume per second, softened within a core radius.")
      .def(py::init([](const py::object& point, double strength, double core) {
             return checked(PointSource{vector(point, "point"), strength, core});
           }),
           py::arg("point"), py::arg("strength"), py::arg("core") = 0.0);
  py::class_<CurlNoise>(module, "CurlNoise", py::module_local(),
                        R"(Turbulence without divergence, the same for a seed everywhere.

speed:             root mean square
longest, shortest: wavelengths, world units
exponent:          of the energy spectrum E(k) ~ k^-exponent
waves:             how many are added)")
      .def(py::init([](double speed, double longest, double shortest, double exponent,
                       std::uint32_t seed, int waves) {
             return checked(CurlNoise{speed, longest, shortest, exponent, seed, waves});
           }),
           py::arg("speed"), py::arg("longest"), py::arg("shortest"),
           py::arg("exponent") = CurlNoise().exponent, py::arg("seed") = 0,
           py::arg("waves") = CurlNoise().waves);
}

}  // namespace

void bindPrimitives(py::module_& module) {
  bindTurning(module);
  bindOthers(module);
  module.def(
      "integrate", &integrals, py::arg("primitive"), py::arg("mesh"), py::arg("degree") = 2,
      py::kw_only(), py::arg("progress") = py::none(),
      R"(Fluxes through facets (degree 2) or circulations along edges (1) of a primitive flow.

Exact, and so free of divergence on the mesh, but in a cell that holds a source. Returns float64
(mesh.complex.count(degree),). Releases the GIL. Raises InputError, Cancelled.)");
  module.def("nearest_closed", &closest, py::arg("mesh"), py::arg("degree"),
             py::arg("coefficients"), py::arg("zero") = py::none(),
             R"(The form without divergence (degree 2) or curl (1) that differs least in energy.

zero: int (n,), simplices that become 0, such as mesh.complex.boundary_facets
Returns float64 (mesh.complex.count(degree),). Releases the GIL. Raises InputError.)");
}

}  // namespace octet::python
