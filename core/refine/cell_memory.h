// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace octet {

/// @file
/// What a cell of the finest level takes in memory, in bytes, at most: measured by
/// tests/bench/memory.cpp.

/// While the operators of its level, and those of all levels before, are built and kept.
inline constexpr double kOperatorBytesPerCell = 400;
/// Besides, while a form is refined and its field is made.
inline constexpr double kFieldBytesPerCell = 200;

}  // namespace octet
