// SPDX-License-Identifier: Apache-2.0
#include "test_data.h"

namespace octet::testing {

std::string testData(const std::string& name) { return OCTET_TEST_DATA "/" + name; }

}  // namespace octet::testing
