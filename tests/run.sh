#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds everything and runs every test, on a bare Debian 12 or Ubuntu machine too (root or sudo).
# Arguments go to ctest: tests/run.sh -R refiner. Without any, the tests of bad input run twice, the
# second time with sanitizers.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/packages.sh
install_packages "${BUILD_PACKAGES[@]}" "${TEST_PACKAGES[@]}"
preset=${OCTETVDB_PRESET:-release}
cmake --preset "$preset" >/dev/null
cmake --build --preset "$preset"
ctest --preset "$preset" "$@"
[ $# -eq 0 ] || exit 0
cmake --preset asan >/dev/null
cmake --build --preset asan --target octetvdb fuzz_replay
ctest --preset asan -L robustness
