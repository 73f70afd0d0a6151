// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

namespace octet::cli {

/// The command's version, those of the libraries that it runs with, what it was built with, and the
/// threads and memory that it may use here.
nlohmann::ordered_json versions();

}  // namespace octet::cli
