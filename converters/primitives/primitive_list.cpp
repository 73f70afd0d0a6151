// SPDX-License-Identifier: Apache-2.0
#include "primitive_list.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include <octet/core/base/error.h>

namespace octet {
namespace {

using Json = nlohmann::json;

/// One object of the list; reads its keys and knows which were asked for.
class Reader {
 public:
  Reader(const Json& object, std::string place) : object_(object), place_(std::move(place)) {
    if (!object.is_object()) throw InputError(place_, "is not an object");
  }

  std::string text(const char* key) {
    const Json& value = find(key, true);
    if (!value.is_string()) fail(key, "is not a string");
    return value.get<std::string>();
  }
  double number(const char* key, std::optional<double> otherwise = {}) {
    const Json& value = find(key, !otherwise);
    if (value.is_null()) return *otherwise;
    if (!value.is_number()) fail(key, "is not a number");
    return value.get<double>();
  }
  int integer(const char* key, int otherwise, double least, double most) {
    const double x = number(key, otherwise);
    if (x != std::floor(x) || x < least || x > most) fail(key, "is not an integer in range");
    return static_cast<int>(static_cast<std::int64_t>(x));
  }
  Vec3 vector(const char* key, std::optional<Vec3> otherwise = {}) {
    const Json& value = find(key, !otherwise);
    if (value.is_null()) return *otherwise;
    const bool three =
        value.is_array() && value.size() == 3 &&
        std::all_of(value.begin(), value.end(), [](const Json& x) { return x.is_number(); });
    if (!three) fail(key, "is not an array of three numbers");
    return {value[0].get<double>(), value[1].get<double>(), value[2].get<double>()};
  }
  [[noreturn]] void fail(const std::string& key, const std::string& reason) const {
    throw InputError(place_ + "." + key, reason);
  }
  /// Refuses keys that nobody asked for: slips, mostly.
  void finish() const {
    for (const auto& [key, value] : object_.items()) {
      if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
        fail(key, "is not a key of this type");
      }
    }
  }

 private:
  const Json& find(const char* key, bool required) {
    static const Json none;
    known_.emplace_back(key);
    const auto found = object_.find(key);
    if (found != object_.end()) return *found;
    if (required) throw InputError(place_, "key \"" + std::string(key) + "\" is missing");
    return none;
  }

  const Json& object_;
  std::string place_;
  std::vector<std::string> known_;
};

Primitive readPrimitive(Reader* r) {
  const std::string type = r->text("type");
  if (type == "uniform") return UniformFlow{r->vector("velocity")};
  if (type == "rotation") {
    return RigidRotation{r->vector("centre", Vec3::Zero()), r->vector("angular_velocity")};
  }
  if (type == "vortex_line") {
    return VortexLine{r->vector("point"), r->vector("direction"), r->number("circulation"),
                      r->number("core", 0)};
  }
  if (type == "vortex_ring") {
    return VortexRing{r->vector("centre"), r->vector("normal"), r->number("radius"),
                      r->number("circulation"), r->number("core", 0)};
  }
  if (type == "source") {
    return PointSource{r->vector("point"), r->number("strength"), r->number("core", 0)};
  }
  if (type != "curl_noise") {
    r->fail("type",
            "\"" + type +
                "\" is none of uniform, rotation, vortex_line, vortex_ring, source, curl_noise");
  }
  CurlNoise noise;
  noise.speed = r->number("speed");
  noise.longest = r->number("longest");
  noise.shortest = r->number("shortest");
  noise.exponent = r->number("exponent", noise.exponent);
  noise.seed = static_cast<std::uint32_t>(r->integer("seed", 0, 0, 2147483647));
  noise.waves = r->integer("waves", noise.waves, 1, 1000000);
  return noise;
}

Json parse(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status)) throw InputError(path, "", "is a folder");
  std::ifstream file(path);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  try {
    return Json::parse(file);
  } catch (const Json::exception& e) {
    throw InputError(path, "", std::string("is not JSON: ") + e.what());
  }
}

}  // namespace

std::vector<Primitive> readPrimitives(const std::string& path) {
  const Json document = parse(path);
  try {
    if (!document.is_object() || !document.contains("primitives") ||
        !document["primitives"].is_array()) {
      throw InputError("", "has no array \"primitives\"");
    }
    std::vector<Primitive> primitives;
    for (const Json& object : document["primitives"]) {
      const std::string place = "primitives[" + std::to_string(primitives.size()) + "]";
      Reader reader(object, place);
      primitives.push_back(readPrimitive(&reader));
      reader.finish();
      try {
        checkPrimitive(primitives.back());
      } catch (const InputError& e) {
        throw InputError(place, e.reason());
      }
    }
    return primitives;
  } catch (const InputError& e) {
    throw e.inFile(path);
  }
}

}  // namespace octet
