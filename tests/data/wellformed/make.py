#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the control assets of this folder: all that one can hold, as JSON and as CBOR.

An octahedron and a tetrahedron that share a facet, creases and corners, a form of each degree, two of
them animated. Tests damage copies of them.
"""
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "malformed"))
import make as malformed  # noqa: E402

ASSET = {
    "octet": 1,
    "name": "good",
    "up_axis": "Y",
    "meters_per_unit": 0.01,
    "frames_per_second": 25,
    "vertices": [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1],
                 [0.75, 0.75, 0.75]],
    "tetrahedra": [[0, 1, 2, 6]],
    "octahedra": [[0, 1, 2, 3, 4, 5]],
    "creases": [[0, 3], [3, 4]],
    "corners": [6],
    "forms": [
        {"name": "pressure", "degree": 0, "unit": "Pa", "simplices": [[0], [6]],
         "values": [1.5, -2.25e-3]},
        {"name": "potential", "degree": 1, "simplices": [[1, 0], [6, 2]],
         "frames": {"1": [1.0, 2.0], "3": [1.5, 2.5]}},
        {"name": "velocity", "degree": 2, "unit": "1/s", "simplices": [[0, 1, 2], [3, 5, 4]],
         "frames": {"2": [0.5, 0.0], "4": [-0.5, 1e-300]}},
        {"name": "mass", "degree": 3, "simplices": [[0, 1, 2, 3, 4, 5], [0, 1, 2, 6]],
         "values": [4, 1]},
    ],
}

if __name__ == "__main__":
    (HERE / "good.octet.json").write_bytes(malformed.to_json(ASSET).encode())
    (HERE / "good.octet").write_bytes(malformed.to_cbor(ASSET))
