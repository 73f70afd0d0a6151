#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures OctetVDB's stages and its sampling against VTK's vtkResampleToImage on the same refined
# mesh, vectors and grid; prints what is reached of the targets. Takes some minutes; nothing else
# should run meanwhile. Installs what it needs on Debian 12 or Ubuntu (root or sudo).
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
. tests/packages.sh
install_packages "${BUILD_PACKAGES[@]}" "${BENCH_PACKAGES[@]}"
cmake --preset release -DOCTETVDB_BUILD_TESTS=OFF >/dev/null
cmake --build --preset release --target octet_bench
bench=build/release/tests/bench
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

echo "== Sampling against VTK"
status=0
for mesh in box lattice; do
  mkdir "$work/$mesh"
  "$bench/export_field" "$work/$mesh" "$mesh" 50k
  /usr/bin/python3 tests/bench/vtk_resample.py "$work/$mesh" || status=1
done

echo "== Stages"
for mesh in box lattice ball; do
  "$bench/core_bench" --benchmark_filter="^(build|apply_[12]_form|limit_2_form|sample_grid)/$mesh/500k/" \
    --benchmark_repetitions=5 --benchmark_enable_random_interleaving=true --benchmark_min_time=0.1 \
    --benchmark_out="$work/$mesh.json" --benchmark_out_format=json >/dev/null 2>&1
done
/usr/bin/python3 tests/bench/stages.py "$work"/*.json

echo "== Peak memory"
for size in 500k 4M; do
  for mesh in box lattice ball; do "$bench/memory" "$mesh" "$size"; done
done
exit $status
