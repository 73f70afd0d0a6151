#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the mesh files of this folder: one mesh in every format that the Gmsh SDK reads.

Two tetrahedra that share a facet, volumes 1/6 and 1/3. Node numbers have gaps and no order, and
node 99 belongs to no tetrahedron. The .msh files also hold creases, a corner and one view for
each degree: "pressure" on nodes, "potential" on lines, "velocity" on triangles (frames 1 and 2),
"density" on tetrahedra.
"""
import pathlib
import struct

NODES = {10: (0, 0, 0), 3: (1, 0, 0), 7: (0, 1, 0), 99: (5, 5, 5), 20: (0, 0, 1), 21: (1, 1, 1)}
POINT, LINE, TRIANGLE, TETRAHEDRON = 15, 1, 2, 4
DIMENSION = {POINT: 0, LINE: 1, TRIANGLE: 2, TETRAHEDRON: 3}
CREASES, CORNERS = 1, 2  # physical groups
# number: (type, entity, nodes); lines 11 and 13 are on the curve of the creases
ELEMENTS = {
    31: (POINT, 1, (21,)),
    11: (LINE, 1, (10, 3)),
    13: (LINE, 1, (20, 21)),
    12: (LINE, 2, (7, 3)),
    21: (TRIANGLE, 1, (3, 7, 20)),
    22: (TRIANGLE, 1, (10, 7, 3)),
    23: (TRIANGLE, 1, (7, 21, 20)),
    1: (TETRAHEDRON, 1, (10, 3, 7, 20)),
    2: (TETRAHEDRON, 1, (3, 7, 20, 21)),
}
PHYSICAL = {(0, 1): CORNERS, (1, 1): CREASES}  # by dimension and entity
VIEWS = [  # section, name, time step, values
    ("NodeData", "pressure", 0, {10: 1, 3: 2, 7: 3, 20: 4, 21: 5, 99: 6}),
    ("ElementData", "potential", 0, {11: 1.5, 12: -2, 13: 0.25}),
    ("ElementData", "velocity", 1, {21: 1, 22: 2, 23: 3}),
    ("ElementData", "velocity", 2, {21: -1, 22: -2.5}),
    ("ElementData", "density", 0, {1: 7, 2: 8}),
]


class Msh:
    """Builds a .msh file, its numbers as text or binary."""

    def __init__(self, version, binary):
        self.binary = binary
        self.out = b""
        size = 8
        self.text(f"$MeshFormat\n{version} {int(binary)} {size}\n")
        if binary:
            self.out += struct.pack("<i", 1) + b"\n"
        self.text('$EndMeshFormat\n$PhysicalNames\n2\n'
                  f'0 {CORNERS} "corners"\n1 {CREASES} "creases"\n$EndPhysicalNames\n')

    def text(self, s):
        self.out += s.encode()

    def numbers(self, form, *values):
        """Numbers in a row: i int, q size_t, d double."""
        if self.binary:
            self.out += struct.pack("<" + form, *values)
        else:
            self.text(" ".join(repr(v) for v in values) + "\n")

    def end(self, section):
        self.text(("\n" if self.binary else "") + f"$End{section}\n")

    def views(self):
        for section, name, step, values in VIEWS:
            self.text(f'${section}\n1\n"{name}"\n1\n{step}\n3\n{step}\n1\n{len(values)}\n')
            for tag, value in values.items():
                self.numbers("id", tag, value)
            self.end(section)


def msh2(binary):
    msh = Msh("2.2", binary)
    msh.text(f"$Nodes\n{len(NODES)}\n")
    for tag, x in NODES.items():
        msh.numbers("iddd", tag, *x)
    msh.end("Nodes")
    msh.text(f"$Elements\n{len(ELEMENTS)}\n")
    for tag, (kind, entity, nodes) in ELEMENTS.items():
        tags = (PHYSICAL.get((DIMENSION[kind], entity), 0), entity)
        if binary:
            msh.numbers("iii", kind, 1, len(tags))
            msh.numbers("i" * (3 + len(nodes)), tag, *tags, *nodes)
        else:
            msh.numbers("", tag, kind, len(tags), *tags, *nodes)
    msh.end("Elements")
    msh.views()
    return msh.out


def msh4(binary):
    msh = Msh("4.1", binary)
    entities = sorted({(DIMENSION[kind], entity) for kind, entity, _ in ELEMENTS.values()})
    msh.text("$Entities\n")
    msh.numbers("qqqq", *(sum(d == k for d, _ in entities) for k in range(4)))
    for dim, entity in entities:
        groups = [PHYSICAL[dim, entity]] if (dim, entity) in PHYSICAL else []
        box = (1.0, 1.0, 1.0) if dim == 0 else (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
        row = [entity, *box, len(groups), *groups] + ([0] if dim else [])
        msh.numbers(f"i{len(box)}dq{len(groups)}i" + ("q" if dim else ""), *row)
    msh.end("Entities")
    msh.text("$Nodes\n")
    msh.numbers("qqqq", 1, len(NODES), min(NODES), max(NODES))
    msh.numbers("iiiq", 3, 1, 0, len(NODES))
    for tag in NODES:
        msh.numbers("q", tag)
    for x in NODES.values():
        msh.numbers("ddd", *x)
    msh.end("Nodes")
    blocks = {}
    for tag, (kind, entity, nodes) in ELEMENTS.items():
        blocks.setdefault((kind, entity), []).append((tag, *nodes))
    msh.text("$Elements\n")
    msh.numbers("qqqq", len(blocks), len(ELEMENTS), min(ELEMENTS), max(ELEMENTS))
    for (kind, entity), rows in blocks.items():
        msh.numbers("iiiq", DIMENSION[kind], entity, kind, len(rows))
        for row in rows:
            msh.numbers("q" * len(row), *row)
    msh.end("Elements")
    msh.views()
    return msh.out


def dense():
    """Nodes numbered from 0 in order of their tags, and the elements in order of theirs."""
    tags = sorted(NODES)
    elements = [(kind, [tags.index(n) for n in nodes])
                for _, (kind, _, nodes) in sorted(ELEMENTS.items())]
    return [NODES[t] for t in tags], elements


def medit():
    points, elements = dense()
    out = "MeshVersionFormatted 2\nDimension\n3\nVertices\n%d\n" % len(points)
    out += "".join("%g %g %g 0\n" % x for x in points)
    for name, kind in (("Edges", LINE), ("Triangles", TRIANGLE), ("Tetrahedra", TETRAHEDRON)):
        rows = [nodes for k, nodes in elements if k == kind]
        out += f"{name}\n{len(rows)}\n"
        out += "".join(" ".join(str(n + 1) for n in nodes) + " 1\n" for nodes in rows)
    return (out + "End\n").encode()


def vtk(binary):
    points, elements = dense()
    cell_types = {POINT: 1, LINE: 3, TRIANGLE: 5, TETRAHEDRON: 10}
    out = b"# vtk DataFile Version 2.0\ntwo tetrahedra\n" + (b"BINARY\n" if binary else b"ASCII\n")

    def numbers(code, values):
        if binary:
            return struct.pack(f">{len(values)}{code}", *values)
        return (" ".join(f"{v:g}" for v in values) + "\n").encode()

    out += f"DATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n".encode()
    for x in points:
        out += numbers("d", x)
    size = sum(1 + len(nodes) for _, nodes in elements)
    out += f"\nCELLS {len(elements)} {size}\n".encode()
    for _, nodes in elements:
        out += numbers("i", [len(nodes), *nodes])
    out += f"\nCELL_TYPES {len(elements)}\n".encode()
    for kind, _ in elements:
        out += numbers("i", [cell_types[kind]])
    return out + b"\n"


if __name__ == "__main__":
    here = pathlib.Path(__file__).parent
    for name, content in {
            "two_tets_22.msh": msh2(False), "two_tets_22_binary.msh": msh2(True),
            "two_tets_41.msh": msh4(False), "two_tets_41_binary.msh": msh4(True),
            "two_tets.mesh": medit(), "two_tets.vtk": vtk(False),
            "two_tets_binary.vtk": vtk(True)}.items():
        (here / name).write_bytes(content)
