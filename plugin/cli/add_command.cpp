// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/converters/primitives/primitive_list.h>
#include <octet/core/base/error.h>
#include <octet/core/forms/coboundary.h>
#include <octet/core/hodge/projection.h>
#include <octet/core/primitives/integrate.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

template <std::size_t N>
using Rows = std::vector<std::array<double, N>>;

struct Arguments {
  std::string control, output, form = "velocity", list;
  int degree = 2;
  bool walls = false, json = false;
  std::vector<Primitive> primitives;
};

/// The form to add to; made when there is none of that name.
Form& targetForm(ControlAsset* asset, const Arguments& arguments) {
  for (Form& form : asset->forms) {
    if (form.name != arguments.form) continue;
    if (form.degree != arguments.degree) {
      throw InputError("--form", "\"" + form.name + "\" has degree " + std::to_string(form.degree) +
                                     ", not --degree " + std::to_string(arguments.degree));
    }
    return form;
  }
  Form form;
  form.name = arguments.form;
  form.degree = arguments.degree;
  form.unit = arguments.degree == 1 ? "m^2/s" : "m^3/s";
  asset->forms.push_back(form);
  return asset->forms.back();
}

/// The form with `w` added to its values or to each of its frames.
template <int K>
Form sum(const ControlAsset& asset, const Form& form, const Cochain<K>& w, bool walls,
         const Context& context) {
  const Complex& complex = *asset.mesh.complex();
  std::unique_ptr<ClosedProjection<K>> projection;
  if (walls) {
    projection = std::make_unique<ClosedProjection<K>>(complex, asset.mesh.positions(),
                                                       onBoundary<K>(complex), context);
  }
  const auto at = [&](int frame) {
    Cochain<K> total = coefficients<K>(asset, form, frame);
    for (Index i = 0; i < total.size(); ++i) total[i] += w[i];
    return projection ? projection->apply(total, /*fixedToZero=*/true, context) : total;
  };
  if (!form.animated()) return makeForm<K>(form.name, at(0), form.unit);
  Form result;
  result.name = form.name;
  result.degree = K;
  result.unit = form.unit;
  for (Index i = 0; i < complex.count(K); ++i) result.simplices.push_back(i);
  result.signs.assign(result.simplices.size(), 1);
  for (const auto& [frame, values] : form.frames) {
    const Cochain<K> total = at(frame);
    result.frames.emplace(frame, std::vector<double>(total.values().begin(), total.values().end()));
  }
  return result;
}

template <int K>
Json add(const Arguments& arguments, ControlAsset* asset) {
  const Complex& complex = *asset->mesh.complex();
  const Context context = consoleContext();
  const double share = 0.7 / static_cast<double>(arguments.primitives.size());
  Cochain<K> w(complex);
  for (const Primitive& primitive : arguments.primitives) {
    const Cochain<K> one =
        integrate<K>(primitive, complex, asset->mesh.positions(), context.sub(share));
    for (Index i = 0; i < w.size(); ++i) w[i] += one[i];
  }
  Form& form = targetForm(asset, arguments);
  form = sum<K>(*asset, form, w, arguments.walls, context);
  Json names = Json::array();
  for (const Primitive& primitive : arguments.primitives) names.push_back(nameOf(primitive));
  const int frame = form.animated() ? form.frames.begin()->first : 0;
  const Cochain<K> total = coefficients<K>(*asset, form, frame);
  return {{"output", arguments.output},
          {"form", form.name},
          {"degree", K},
          {"added", names},
          {"max", maxNorm(total.values())},
          {"max_derivative", maxNorm(d(complex, total).values())}};
}

void checkArguments(const Arguments& arguments) {
  if (arguments.primitives.empty()) throw InputError("", "add needs a primitive; see add --help");
  for (const Primitive& primitive : arguments.primitives) checkPrimitive(primitive);
  if (!arguments.walls) return;
  if (arguments.degree != 2) throw InputError("--walls", "is for fluxes, --degree 2");
  for (const Primitive& primitive : arguments.primitives) {
    if (std::holds_alternative<PointSource>(primitive)) {
      throw InputError("--walls", "leaves a source no way out");
    }
  }
}

void run(Arguments& arguments) {
  if (!arguments.list.empty()) {
    for (const Primitive& p : readPrimitives(arguments.list)) arguments.primitives.push_back(p);
  }
  checkArguments(arguments);
  checkSingleOutput(arguments.control, arguments.output);
  ControlAsset asset = readAsset(arguments.control);
  const Json summary =
      arguments.degree == 1 ? add<1>(arguments, &asset) : add<2>(arguments, &asset);
  writeControlAsset(asset, arguments.output);
  if (arguments.json) {
    std::cout << text(summary) << "\n";
  } else {
    std::cout << "added to \"" << arguments.form << "\", largest coefficient "
              << summary["max"].get<double>() << ", of its derivative "
              << summary["max_derivative"].get<double>() << "\n";
  }
}

/// Adds an option that makes a primitive of N numbers, each time it is given.
template <std::size_t N, typename Make>
void addPrimitive(CLI::App* command, const std::shared_ptr<Arguments>& arguments,
                  const std::string& option, const std::string& help, const Make& make) {
  const auto read = [=](const std::vector<double>& x) {
    for (std::size_t k = 0; k + N <= x.size(); k += N) {
      arguments->primitives.push_back(make(x.data() + k));
    }
  };
  command->add_option_function<std::vector<double>>(option, read, help)
      ->type_size(static_cast<int>(N))
      ->expected(1, 1 << 20)
      ->type_name("NUMBERS");
}

std::uint32_t seedOf(double x) {
  if (!(x >= 0 && x <= 4294967295.0) || x != std::floor(x)) {
    throw InputError("--curl-noise", "the seed is not an integer from 0 to 4294967295");
  }
  return static_cast<std::uint32_t>(x);
}

}  // namespace

void addAdd(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "add", "Add primitive flows to a form of a control asset; options may be repeated");
  command->add_option("CONTROL", arguments->control, "Control asset or mesh")->required();
  command->add_option("-o,--output", arguments->output, "Control asset to write")->required();
  command
      ->add_option("--form", arguments->form, "Form to add to; made when there is none of the name")
      ->capture_default_str();
  command->add_option("--degree", arguments->degree, "1 for circulations, 2 for fluxes")
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  command->add_flag("--walls", arguments->walls,
                    "Then take the nearest flow without divergence and without flux through the "
                    "boundary");
  const auto at = [](const double* x) { return Vec3(x[0], x[1], x[2]); };
  addPrimitive<3>(command, arguments, "--uniform", "Uniform flow: velocity x y z",
                  [=](const double* x) { return UniformFlow{at(x)}; });
  addPrimitive<6>(command, arguments, "--rotation",
                  "Rigid rotation: centre x y z, angular velocity x y z", [=](const double* x) {
                    return RigidRotation{at(x), at(x + 3)};
                  });
  addPrimitive<8>(command, arguments, "--vortex-line",
                  "Straight vortex: point x y z, direction x y z, circulation, core radius",
                  [=](const double* x) {
                    return VortexLine{at(x), at(x + 3), x[6], x[7]};
                  });
  addPrimitive<9>(command, arguments, "--vortex-ring",
                  "Vortex ring: centre x y z, normal x y z, radius, circulation, core radius",
                  [=](const double* x) {
                    return VortexRing{at(x), at(x + 3), x[6], x[7], x[8]};
                  });
  addPrimitive<5>(command, arguments, "--source",
                  "Source, or sink: point x y z, volume per second, core radius",
                  [=](const double* x) {
                    return PointSource{at(x), x[3], x[4]};
                  });
  addPrimitive<4>(command, arguments, "--curl-noise",
                  "Turbulence: rms speed, longest and shortest wavelength, seed",
                  [=](const double* x) {
                    CurlNoise noise;
                    noise.speed = x[0];
                    noise.longest = x[1];
                    noise.shortest = x[2];
                    noise.seed = seedOf(x[3]);
                    return noise;
                  });
  command->add_option("--primitives", arguments->list,
                      "JSON document with a list \"primitives\" of these");
  command->add_flag("--json", arguments->json, "Print the summary as JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
