// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include <octet/core/analysis/continuity.h>
#include <octet/core/analysis/local_subdivision.h>
#include <octet/core/analysis/spectrum.h>
#include <octet/core/base/error.h>
#include <octet/core/refine/interior_moves.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Arguments {
  std::string control;
  Index vertex = 0;
  int level = 0;
  std::vector<int> degrees;
  LocalSubdivisionOptions options;
  bool asItIs = false, withoutPatchTest = false, vectors = false, json = false;
};

/// Constants reproduced to this count as exact.
constexpr double kExact = 1e-9;

const char* typeName(VertexType type) {
  constexpr const char* kNames[] = {"R", "X1", "X2", "X3", "B1", "B2", "B3"};
  return kNames[static_cast<int>(type)];
}

const char* degreeName(int degree) {
  constexpr const char* kNames[] = {"vertices", "edges", "facets"};
  return kNames[degree];
}

/// Vertices of the simplices that are rows and columns, numbered as in the mesh.
Json simplices(const LocalSubdivision& local, int degree) {
  const Complex& c = local.star();
  Json result = Json::array();
  const auto name = [&](Index v) { return local.vertices()[static_cast<std::size_t>(v)]; };
  for (Index s = 0; s < c.count(degree); ++s) {
    Json simplex = Json::array();
    if (degree == 0) simplex = {name(s)};
    if (degree == 1) simplex = {name(c.edges[s][0]), name(c.edges[s][1])};
    if (degree == 2) {
      for (const Index v : c.facetVertices(s)) simplex.push_back(name(v));
    }
    result.push_back(simplex);
  }
  return result;
}

Json number(std::complex<double> value) {
  return value.imag() == 0 ? Json(value.real()) : Json({value.real(), value.imag()});
}

template <typename Vector>
Json vector(const Vector& values) {
  const bool real = values.imag().cwiseAbs().maxCoeff() < 1e-12;
  Json result = Json::array();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    result.push_back(number(real ? values[k].real() : values[k]));
  }
  return result;
}

Json eigenvalueList(const std::vector<Eigenvalue>& values, bool vectors) {
  Json result = Json::array();
  for (const Eigenvalue& value : values) {
    Json entry = {{"value", number(value.value)}, {"multiplicity", value.multiplicity}};
    if (vectors) {
      entry["eigenforms"] = entry["left"] = Json::array();
      for (Eigen::Index k = 0; k < value.forms.cols(); ++k) {
        entry["eigenforms"].push_back(vector(value.forms.col(k)));
      }
      for (Eigen::Index k = 0; k < value.left.rows(); ++k) {
        entry["left"].push_back(vector(value.left.row(k).transpose()));
      }
    }
    result.push_back(entry);
  }
  return result;
}

/// A field is continuous at the vertex when what is not constant in it dies out.
template <int K>
Json continuityOf(const LocalSubdivision& local, bool closedOnly) {
  const Continuity c = continuity<K>(local, closedOnly);
  return {{"constants", {c.constants[0], c.constants[1], c.constants[2]}},
          {"constants_error", c.constantsError},
          {"growth", c.growth},
          {"eigenvalue", c.eigenvalue},
          {"continuous", c.constantsError < kExact && c.growth < 1}};
}

template <int K>
Json analyse(const LocalSubdivision& local, const Arguments& arguments) {
  const Eigen::MatrixXd matrix = local.matrix<K>();
  const auto values = spectrum(matrix, arguments.vectors);
  Json entry = {{"degree", K}, {"size", matrix.rows()}};
  if constexpr (K > 0) {
    entry["any"] = continuityOf<K>(local, false);
    entry["closed"] = continuityOf<K>(local, true);
  }
  entry["eigenvalues"] = eigenvalueList(values, arguments.vectors);
  if (arguments.vectors) entry["simplices"] = simplices(local, K);
  return entry;
}

void print(const Json& entry) {
  const int degree = entry["degree"];
  std::printf("degree %d: %d %s\n", degree, entry["size"].get<int>(), degreeName(degree));
  for (const Json& value : entry["eigenvalues"]) {
    const int multiplicity = value["multiplicity"];
    if (value["value"].is_array()) {
      std::printf("  %.9f %+.9fi  (%d)\n", value["value"][0].get<double>(),
                  value["value"][1].get<double>(), multiplicity);
    } else {
      std::printf("  %.9f  (%d)\n", value["value"].get<double>(), multiplicity);
    }
  }
  if (degree == 0) return;
  const Json& any = entry["any"];
  std::printf("  constants %.9f %.9f %.9f, reproduced to %.1e\n", any["constants"][0].get<double>(),
              any["constants"][1].get<double>(), any["constants"][2].get<double>(),
              any["constants_error"].get<double>());
  for (const char* which : {"any", "closed"}) {
    const Json& c = entry[which];
    std::printf("  %s field: what is not constant changes by %.6f per level: %s\n", which,
                c["growth"].get<double>(),
                c["continuous"] ? "continuous here" : "not continuous here");
  }
}

void run(Arguments& arguments) {
  const ControlAsset asset = readAsset(arguments.control);
  RefinerOptions options;
  options.levels = arguments.level;
  options.zeta = arguments.options.zeta;
  options.boundaryRows = arguments.options.boundaryRows;
  const Refiner refiner(asset.mesh, options, consoleContext());
  arguments.options.settle = !arguments.asItIs;
  arguments.options.patchTest = !arguments.withoutPatchTest;
  const LocalSubdivision local(refiner, arguments.level, arguments.vertex, arguments.options);
  if (arguments.degrees.empty()) arguments.degrees = {0, 1, 2};
  const Complex& star = local.star();
  const bool folds = starFolds(IrregularStars(refiner.complex(arguments.level)), arguments.vertex);
  Json report = {{"asset", asset.name},
                 {"vertex", arguments.vertex},
                 {"level", arguments.level},
                 {"type", typeName(local.type())},
                 {"zeta", arguments.options.zeta},
                 {"tetrahedra", star.tetCount()},
                 {"octahedra", star.octCount()},
                 {"folds", folds},
                 {"degrees", Json::array()}};
  for (const int degree : arguments.degrees) {
    report["degrees"].push_back(degree == 0   ? analyse<0>(local, arguments)
                                : degree == 1 ? analyse<1>(local, arguments)
                                              : analyse<2>(local, arguments));
  }
  if (arguments.json) {
    std::cout << text(report) << "\n";
    return;
  }
  std::printf("vertex %d of level %d, type %s: %d tetrahedra, %d octahedra; zeta %g\n",
              arguments.vertex, arguments.level, typeName(local.type()), star.tetCount(),
              star.octCount(), arguments.options.zeta);
  if (folds)
    std::printf("its shape folds when subdivision settles it: cells beside it turn over\n");
  for (const Json& entry : report["degrees"]) print(entry);
}

}  // namespace

void addAnalyse(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "analyse", "Eigenvalues and eigenforms of the subdivision around a vertex");
  command
      ->add_option("CONTROL", arguments->control, "Control asset (*.octet.json, *.octet) or mesh")
      ->required();
  command->add_option("--vertex", arguments->vertex, "Vertex of the level, counted from 0")
      ->required();
  command
      ->add_option("--level", arguments->level,
                   "Look at the mesh after this many subdivisions, where vertices on control "
                   "edges and facets are")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  command->add_option("--degree", arguments->degrees, "Only forms of this degree; repeatable")
      ->check(CLI::Range(0, 2));
  command
      ->add_option("--zeta", arguments->options.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
  addChoice<BoundaryMode>(command, "--boundary", &arguments->options.mode,
                          {{"walls", BoundaryMode::Walls}, {"open", BoundaryMode::Open}},
                          "Rules at a vertex on the boundary; walls by default");
  addWallSurface(command, &arguments->options.boundaryRows);
  command->add_flag("--as-it-is", arguments->asItIs,
                    "With the star's own shape, not the one that subdivision brings it to");
  command->add_flag("--without-patch-test", arguments->withoutPatchTest,
                    "Without the correction that makes constant fluxes exact");
  command->add_flag("--vectors", arguments->vectors,
                    "With eigenforms and left eigenvectors, in JSON");
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace octet::cli
