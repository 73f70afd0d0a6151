#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A control asset to any mesh format that meshio writes, or such a mesh to a control asset.

Usage: convert_mesh.py IN OUT, one of which ends in .octet.json or .octet
"""
import sys

import meshio

import octetvdb

CONTROL = (".octet.json", ".octet")


def main(source, target):
    if source.endswith(CONTROL) == target.endswith(CONTROL):
        sys.exit("convert_mesh: one of the two has to be a control asset, *.octet.json or *.octet")
    if source.endswith(CONTROL):
        asset = octetvdb.ControlAsset.read(source)
        meshio.write(target, octetvdb.to_meshio(asset))
    else:
        asset = octetvdb.from_meshio(meshio.read(source))
        asset.write(target)
    print(f"{target}: {asset}")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
