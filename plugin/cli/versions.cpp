// SPDX-License-Identifier: Apache-2.0
#include "versions.h"

#include <CLI/Version.hpp>
#include <nlohmann/json.hpp>

#include <tbb/global_control.h>

#include <octet/converters/versions.h>
#ifdef OCTETVDB_WITH_PICTURES
#include <octet/converters/picture/versions.h>
#endif
#include <octet/core/base/memory_budget.h>
#include <octet/version.h>

namespace octet::cli {

nlohmann::ordered_json versions() {
  using Json = nlohmann::ordered_json;
  Json libraries = Json::object();
  for (const auto& [name, version] : libraryVersions()) libraries[name] = version;
#ifdef OCTETVDB_WITH_PICTURES
  for (const auto& [name, version] : pictureLibraryVersions()) libraries[name] = version;
#endif
  libraries["cli11"] = CLI11_VERSION;
  const bool thesis =
#ifdef OCTETVDB_WITH_THESIS
      true;
#else
      false;
#endif
  const bool pictures =
#ifdef OCTETVDB_WITH_PICTURES
      true;
#else
      false;
#endif
  return {
      {"octetvdb", kVersion},
      {"libraries", std::move(libraries)},
      {"compiler",
#ifdef __clang__
       "Clang " __clang_version__
#else
       "GCC " __VERSION__
#endif
      },
      {"pictures", pictures},
      {"thesis", thesis},
      {"threads", tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism)},
      {"memory_bytes", memoryLimit()}};
}

}  // namespace octet::cli
