// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "../control_asset/refined_document.h"
#include "bake_reason.h"

/// @file
/// What is decided, in words: the one place, for files, the command line and Python.

namespace octet {

/// Says a reason as a part of a sentence.
std::string words(const BakeReason& reason);
/// Says reasons one after another; empty for none.
std::string words(const std::vector<BakeReason>& reasons);

/// Names a kind of reason as machines read it, such as "not_closed".
const char* reasonName(const BakeReason& reason);
/// Names a method as files and reports do; empty for none.
const char* methodName(GridMethod method);
/// Names how a form meets the boundary: its mode, or the subdivision's own rule, if it has one.
std::string boundaryWord(const std::string& rule, BoundaryMode mode);

/// The wall's surface: "smooth" or "loop".
const char* wallSurfaceWord(BoundaryRows rows);

}  // namespace octet
