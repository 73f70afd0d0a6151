// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include <octet/converters/vdb/certificate.h>

namespace octet::cli {

/// A certificate for --json.
nlohmann::ordered_json toJson(const Certificate& certificate);

/// A certificate as lines of text, each with this indent.
void printCertificate(const Certificate& certificate, const char* indent);

}  // namespace octet::cli
