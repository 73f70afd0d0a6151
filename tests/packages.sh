# SPDX-License-Identifier: Apache-2.0
# install_packages NAME...: Debian or Ubuntu packages that are not there yet, as root or with sudo.
install_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  local sudo=
  [ "$(id -u)" -eq 0 ] || sudo=sudo
  echo "installing ${missing[*]}" >&2
  $sudo apt-get update -qq >&2
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
}

# What the library and the command need.
BUILD_PACKAGES=(g++ cmake ninja-build libtbb-dev libeigen3-dev libspectra-dev libopenvdb-dev
  libboost-iostreams-dev nlohmann-json3-dev libcli11-dev libgmsh-dev libcgal-dev
  libassimp-dev)
# What streamlines and pictures need.
BUILD_PACKAGES+=(libboost-dev libcairo2-dev libembree-dev libopenexr-dev)
# What the tests need besides.
TEST_PACKAGES=(python3 git libgtest-dev libbenchmark-dev libosd-dev python3-openvdb python3-numpy python3-gmsh
  libopenvdb-tools clang-format)
# What the Python module and the Blender add-on need, and their tests.
BUILD_PACKAGES+=(pybind11-dev python3-dev)
TEST_PACKAGES+=(python3-pytest python3-meshio blender xvfb xauth)
TEST_PACKAGES+=(libtinyexr-dev openimageio-tools)
# What the tests of farms, packages and the man page need.
TEST_PACKAGES+=(slurm-wlm python3-yaml man-db dpkg-dev)
# What the build with sanitizers needs: Clang, as GCC takes twice as long for it.
SANITIZER_PACKAGES=(clang libclang-rt-dev)
# What the benchmarks and the comparison with VTK need besides the build.
BENCH_PACKAGES=(libbenchmark-dev python3-numpy python3-vtk9)
