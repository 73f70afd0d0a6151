#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds everything and runs every test, on a bare Debian 12 or Ubuntu machine too (root or sudo).
# Arguments go to ctest: tests/run.sh -R refiner
# tests/run.sh --sanitizers: the tests of bad input, with the command built with ASan and UBSan.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/packages.sh
install_packages "${BUILD_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
if [ "${1:-}" = --sanitizers ]; then
  install_packages "${SANITIZER_PACKAGES[@]}"
  cmake --preset asan >/dev/null
  cmake --build --preset asan --target octetvdb fuzz_replay
  exec ctest --preset asan -L robustness
fi
preset=${OCTETVDB_PRESET:-release}
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset"
ctest --preset "$preset" "$@"
