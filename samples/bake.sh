#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds octetvdb, on a bare Debian 12 or Ubuntu machine too (root or sudo), and bakes a sample to
# out/:  samples/bake.sh [SAMPLE] [options of octetvdb bake]
# SAMPLE is a folder here (default: box), or "all". Default resolution: 128.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
. tests/packages.sh

sample=box
if [ $# -gt 0 ] && [[ $1 != -* ]]; then
  sample=$1
  shift
fi
shopt -s nullglob
if [ "$sample" = all ]; then
  assets=(samples/*/*.octet.json)
else
  assets=(samples/"$sample"/*.octet.json)
fi
if [ ${#assets[@]} -eq 0 ]; then
  names=(samples/*/*.octet.json)
  echo "bake.sh: no sample is called \"$sample\"; there are:" \
    $(printf '%s\n' "${names[@]}" | cut -d/ -f2 | sort -u) all >&2
  exit 2
fi
options=("$@")
[[ " $* " == *" --resolution"* || " $* " == *" --voxel-size"* ]] || options+=(--resolution 128)

install_packages "${BUILD_PACKAGES[@]}"
preset=${OCTETVDB_PRESET:-release}  # as for tests/run.sh
cmake --preset "$preset" -DOCTETVDB_BUILD_TESTS=OFF -DOCTETVDB_BUILD_BENCHMARKS=OFF >/dev/null
cmake --build --preset "$preset" --target octetvdb octetvdb-gmsh

mkdir -p out
for asset in "${assets[@]}"; do
  name=$(basename "$asset" .octet.json)
  echo "octetvdb bake $asset ${options[*]} -o out/$name.vdb"
  build/release/plugin/cli/octetvdb bake "$asset" "${options[@]}" -o "out/$name.vdb"
done
