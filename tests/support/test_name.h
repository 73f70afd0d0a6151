// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cctype>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/meshes.h"

namespace octet::testing {

/// The name of a test on a mesh: GoogleTest takes letters, digits and underscores only.
inline std::string testName(const ::testing::TestParamInfo<NamedMesh>& info) {
  std::string name = info.param.name;
  for (char& c : name) {
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  }
  return name;
}

}  // namespace octet::testing
