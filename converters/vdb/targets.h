// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace octet {

/// @brief What a renderer or DCC tool expects of a .vdb (converters/README.md, "Targets"). The
/// one place in the code where these are written down.
struct Target {
  const char* name;          ///< as given on the command line
  const char* velocityName;  ///< grid name that it looks for; empty: the form's own
  char upAxis;               ///< 'Y' or 'Z'; 0: whatever the asset has
  bool voxelCornered;        ///< draws voxel ijk centred at ijk + 1/2, so the grid moves by -h/2
  bool fogClass;             ///< vectors need class "fog volume" to be read
  const char* note;          ///< what the importer has to do
};

/// All targets, "openvdb" first.
const std::vector<Target>& targets();

/// @throws InputError listing the names there are.
const Target& findTarget(const std::string& name);

}  // namespace octet
