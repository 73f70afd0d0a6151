#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian packages in a clean chroot of this system's release and uses each of them: what the
# README says first, the man page, bash's completion, a C++ project, the Python module, the add-on in
# Blender. As root, with debootstrap; some minutes, most of them for what apt fetches (Blender is 0.6 GB).
#
#   cmake --preset packages && cmake --build --preset packages
#   tests/install/chroot.sh [build/packages] [--keep FOLDER] [--without-blender]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
debs=build/packages keep= blender=yes
while [ $# -gt 0 ]; do
  case $1 in
    --keep) keep=$2; shift ;;
    --without-blender) blender= ;;
    *) debs=$1 ;;
  esac
  shift
done
. /etc/os-release
root=${keep:-$(mktemp -d /var/tmp/octetvdb-chroot.XXXXXX)}
[ -n "$keep" ] || trap 'rm -rf --one-file-system "$root"' EXIT

# Mounts live in a name space of their own and end with it.
enter() {
  unshare --mount --pid --fork --kill-child -- bash -c 'root=$1; shift; mount --make-rprivate /
    mount -t proc proc $root/proc; mount --rbind /dev $root/dev; mount -t sysfs sys $root/sys
    exec chroot $root /usr/bin/env -i HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin \
      DEBIAN_FRONTEND=noninteractive bash -euc "$*; exit \$?"' - "$root" "$@"
}
say() { echo "== $*"; }

if [ ! -e "$root/usr/bin/apt-get" ]; then
  say "a clean $VERSION_CODENAME"
  mirror=$(awk '/^URIs:/{print $2; exit}' /etc/apt/sources.list.d/*.sources 2>/dev/null || true)
  debootstrap --variant=minbase --include=ca-certificates "$VERSION_CODENAME" "$root" \
    ${mirror:+"$mirror"} >/dev/null
  cp /etc/resolv.conf /etc/hosts "$root/etc/"
  cp /etc/apt/apt.conf.d/99* "$root/etc/apt/apt.conf.d/" 2>/dev/null || true
fi
mkdir -p "$root/debs"
rm -f "$root"/debs/*
cp "$debs"/*.deb "$root/debs/"
[ -n "$blender" ] || rm "$root"/debs/blender-octetvdb*
# Manual pages are left out of Debian's smallest systems, unless asked for.
rm -f "$root"/etc/dpkg/dpkg.cfg.d/docker

say "apt-get install $(cd "$root/debs" && ls -m)"
enter 'apt-get update -qq; apt-get install -y -qq --reinstall --no-install-recommends /debs/*.deb man-db \
  bash-completion g++ cmake ninja-build >/tmp/apt.log 2>&1 || { tail -50 /tmp/apt.log; exit 1; }'
enter 'dpkg-query -W "*octetvdb*"'

say "the command"
enter 'cd /tmp; octetvdb --version --json; asset=/usr/share/octetvdb/samples/box.octet.json
  octetvdb bake $asset --form velocity --grid staggered --resolution 64 -o box.vdb
  octetvdb verify box.vdb --max-divergence 2e-6
  octetvdb preview box.vdb --view 3d -o streamlines.png
  octetvdb fill --box 0 0 0 1 1 1 --cells tetrahedra --spacing 0.5 -o cage.octet.json | head -4
  octetvdb bake /usr/share/octetvdb/samples/animated.octet.json --frames 1-3 --resolution 16 -o a.####.vdb
  test -s streamlines.png -a -s a.0003.vdb'
say "its man page and completion"
enter 'man octetvdb | grep -A2 "EXIT STATUS"
  source /usr/share/bash-completion/bash_completion; _completion_loader octetvdb || true
  COMP_WORDS=(octetvdb bake x --target ho) COMP_CWORD=4; _octetvdb; echo "--target ho: ${COMPREPLY[*]}"
  test "${COMPREPLY[*]}" = houdini'

say "the library, by a C++ project"
cp -r tests/install/consumer "$root/tmp/"
enter 'cd /tmp/consumer; cmake -G Ninja -B build >/dev/null; cmake --build build >/dev/null
  build/consumer /usr/share/octetvdb/samples/box.octet.json /tmp/consumer.vdb'

say "the Python module"
enter 'cd /tmp; python3 -c "
import octetvdb
asset = octetvdb.ControlAsset.read(\"/usr/share/octetvdb/samples/box.octet.json\")
report = octetvdb.bake(asset, \"module.vdb\", resolution=32, forms=[\"velocity\"], grid=\"staggered\")
print(octetvdb.__version__, octetvdb.__file__, report.files[0].grids[0].certificate.max_divergence)
octetvdb.preview(asset, \"slice.png\", form=\"velocity\")"'

if [ -n "$blender" ]; then
  say "the add-on"
  enter 'cd /tmp; blender -b --factory-startup --python-exit-code 1 --python-expr "
import addon_utils, bpy
assert any(m.__name__ == \"octetvdb_addon\" for m in addon_utils.modules()), \"not offered\"
bpy.ops.preferences.addon_enable(module=\"octetvdb_addon\")
bpy.ops.mesh.primitive_cube_add(size=2)
print([name for name in dir(bpy.ops.octetvdb)])
from octetvdb_addon import library
print(library.need().__file__)" 2>&1 | grep -v "^$"'
fi
say "all of it works"
