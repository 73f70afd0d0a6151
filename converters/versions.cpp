// SPDX-License-Identifier: Apache-2.0
#include "versions.h"

#include <Eigen/Core>
#include <boost/version.hpp>
#include <nlohmann/json.hpp>

#include <assimp/version.h>
#include <openvdb/version.h>
#include <tbb/version.h>

namespace octet {
namespace {

std::string joined(std::initializer_list<unsigned> numbers) {
  std::string text;
  for (const unsigned number : numbers) text += (text.empty() ? "" : ".") + std::to_string(number);
  return text;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> libraryVersions() {
  // "2021.8": oneTBB tells two numbers in one, 12080, of its interface.
  const std::string tbb = TBB_runtime_version();
  return {
      {"openvdb", openvdb::getLibraryVersionString()},
      {"onetbb", tbb},
      {"eigen", joined({EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION})},
      {"assimp", joined({aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch()})},
      {"boost", joined({BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, BOOST_VERSION % 100})},
      {"nlohmann_json", joined({NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                NLOHMANN_JSON_VERSION_PATCH})}};
}

}  // namespace octet
