// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace octet::cli {

/// The command's version, those of the libraries that it runs with, and what it was built with.
nlohmann::ordered_json versions();

}  // namespace octet::cli
