// SPDX-License-Identifier: Apache-2.0
#include "targets.h"

#include <octet/core/base/error.h>
#include <octet/core/base/suggestion.h>

namespace octet {

const std::vector<Target>& targets() {
  static const std::vector<Target> table = {
      // name, velocity, up, cornered, fog, note
      {"openvdb", "", 0, false, false, "grids are named after their forms"},
      {"blender", "velocity", 'Z', true, false,
       "set the volume's velocity unit to seconds (velocity_unit = 'SECOND')"},
      {"houdini", "vel", 'Y', false, false, ""},
      {"arnold", "velocity", 0, false, false, "units per second; velocity_fps 24"},
      {"renderman", "velocity", 0, false, true, "one file per frame"},
  };
  return table;
}

const Target& findTarget(const std::string& name) {
  std::vector<std::string> names;
  for (const Target& target : targets()) {
    if (target.name == name) return target;
    names.emplace_back(target.name);
  }
  throw InputError("target",
                   "\"" + name + "\" is none of " + listOf(names) + didYouMean(name, names));
}

}  // namespace octet
