// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include <octet/core/topology/control_mesh.h>

namespace octet::cli {

/// What `info` and the commands that make cages tell of a control mesh: counts, vertex types,
/// valences, volume, box, and the quality of its cells and boundary.
nlohmann::ordered_json describeMesh(const ControlMesh& mesh);

/// "key: value" lines, lists of objects indented under their key.
void printPlain(const nlohmann::ordered_json& value, const std::string& indent = "");

}  // namespace octet::cli
