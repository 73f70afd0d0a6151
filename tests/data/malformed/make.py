# SPDX-License-Identifier: Apache-2.0
"""Writes the malformed control assets beside this script, or into the folder given.

Each file has one defect, which its name says; tests/plugin/malformed_test.py knows what the command
has to answer. Run again after a change: the files come out the same byte for byte.
"""
import copy
import json
import pathlib
import struct
import sys

NAN = float("nan")
INFINITY = float("inf")
DELETE = object()


# ---- well-formed assets to damage ---------------------------------------------------------------


def tetrahedron():
    return {
        "octet": 1,
        "name": "tetrahedron",
        "up_axis": "Z",
        "meters_per_unit": 1.0,
        "frames_per_second": 24,
        "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
        "tetrahedra": [[0, 1, 2, 3]],
        "creases": [[0, 1]],
        "corners": [3],
        "forms": [flux()],
    }


def flux():
    return {"name": "velocity", "degree": 2, "unit": "1/s",
            "simplices": [[0, 1, 2], [0, 1, 3]], "values": [1.0, -0.5]}


def animated():
    form = {"name": "potential", "degree": 1, "simplices": [[0, 1], [1, 2]],
            "frames": {"1": [1.0, 2.0], "2": [1.5, 2.5]}}
    return {**tetrahedron(), "forms": [form]}


def octahedron():
    """Pole, ring of four, pole."""
    return {
        "octet": 1,
        "vertices": [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1]],
        "octahedra": [[0, 1, 2, 3, 4, 5]],
    }


def star():
    """Eight tetrahedra around vertex 6, the centre of an octahedron."""
    document = octahedron()
    document["vertices"].append([0, 0, 0])
    ring = [(1, 2), (2, 3), (3, 4), (4, 1)]
    document["tetrahedra"] = [[6, pole, a, b] for pole in (0, 5) for a, b in ring]
    del document["octahedra"]
    return document


def tetrahedra(vertices, cells):
    return {"octet": 1, "vertices": vertices, "tetrahedra": cells}


def with_form(document, degree, simplices):
    form = {"name": "f", "degree": degree, "simplices": simplices,
            "values": [1.0 + k for k in range(len(simplices))]}
    return {**document, "forms": [form]}


def changed(document, *path, to):
    """A copy in which the entry at `path` is `to`; with DELETE it is gone."""
    document = copy.deepcopy(document)
    parent = document
    for step in path[:-1]:
        parent = parent[step]
    if to is DELETE:
        del parent[path[-1]]
    else:
        parent[path[-1]] = to
    return document


# ---- writing ------------------------------------------------------------------------------------


class Raw:
    """Text of a JSON value, or bytes of a CBOR item, written as they are."""

    def __init__(self, content):
        self.content = content


def to_json(value):
    """JSON with a line for each key of the document."""
    lines = [f"{json.dumps(key)}: {json_value(entry)}" for key, entry in value.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def json_value(value):
    if isinstance(value, Raw):
        return value.content
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)}: {json_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(json_value(v) for v in value) + "]"
    return json.dumps(value)


def head(major, argument):
    """First bytes of a CBOR item."""
    if argument < 24:
        return bytes([major << 5 | argument])
    for code, form, bits in ((24, ">B", 8), (25, ">H", 16), (26, ">I", 32), (27, ">Q", 64)):
        if argument < 1 << bits:
            return bytes([major << 5 | code]) + struct.pack(form, argument)
    raise ValueError(argument)


def to_cbor(value):
    if isinstance(value, Raw):
        return value.content
    if isinstance(value, dict):
        return head(5, len(value)) + b"".join(to_cbor(k) + to_cbor(v) for k, v in value.items())
    if isinstance(value, list):
        return head(4, len(value)) + b"".join(map(to_cbor, value))
    if isinstance(value, str):
        return head(3, len(value.encode())) + value.encode()
    if isinstance(value, int):
        return head(0, value) if value >= 0 else head(1, -1 - value)
    return b"\xfb" + struct.pack(">d", value)


# ---- defects ------------------------------------------------------------------------------------


def broken_text():
    """Files that are no JSON; names to text or bytes."""
    good = to_json(tetrahedron())

    def until(text):
        return good[:good.index(text) + len(text)]

    return {
        "empty": "",
        "whitespace_only": " \n\t\n",
        "not_json": "vertices 4\n0 0 0\n",
        "byte_order_mark_only": "\ufeff",
        "utf16": good.encode("utf-16-le"),
        "truncated_in_key": until('"meters_per'),
        "truncated_in_number": until('"meters_per_unit": 1.'),
        "truncated_in_string": until('"name": "tetra'),
        "truncated_in_array": until('"tetrahedra": [[0, 1,'),
        "truncated_in_literal": to_json({"vertices": Raw("nul")}),
        "truncated_at_end": good.rstrip()[:-1],
        "trailing_comma": good.replace("-0.5]", "-0.5,]"),
        "trailing_text": good + "end\n",
        "two_documents": good + good,
        "single_quotes": good.replace('"', "'"),
        "comment": "// a cage\n" + good,
        "missing_colon": good.replace('"name":', '"name"'),
        "zero_bytes_at_end": good + "\0\0\0",
        "zero_byte": good.replace('"name"', "\0"),
        "line_break_in_string": good.replace("tetrahedron", "tetra\nhedron"),
        "name_not_utf8": good.encode().replace(b"tetrahedron", b"t\xe9tra\xe8dre"),
        "token_nan": to_json(changed(tetrahedron(), "vertices", 3, 0, to=NAN)),
        "token_infinity": to_json(changed(tetrahedron(), "vertices", 3, 0, to=INFINITY)),
        "token_minus_infinity": to_json(changed(tetrahedron(), "vertices", 3, 0, to=-INFINITY)),
        "number_hexadecimal": to_json(changed(tetrahedron(), "vertices", 3, 0, to=Raw("0x10"))),
        "number_with_comma": to_json(changed(tetrahedron(), "meters_per_unit", to=Raw("0,5"))),
    }


def broken_documents():
    """Documents that are JSON, but not of the right shape."""
    one = tetrahedron()
    twice = {"degree": 2, "simplices": [], "values": []}
    return {
        "number_overflows": changed(one, "vertices", 3, 0, to=Raw("1e999")),
        "key_twice": {**one, "corners": Raw('[],\n"octet": 1')},
        "key_twice_in_form": {**one, "forms": [{**twice, "name": Raw('"f", "degree": 1')}]},
        "nested_deeply": {**one, "extra": Raw("[" * 100 + "]" * 100)},
        "no_vertices": changed(one, "vertices", to=DELETE),
        "no_cells": changed(one, "tetrahedra", to=DELETE),
        "empty_object": {},
        "vertices_empty": changed(one, "vertices", to=[]),
        "version_2": changed(one, "octet", to=2),
        "version_text": changed(one, "octet", to="1"),
        "name_number": changed(one, "name", to=5),
        "up_axis_x": changed(one, "up_axis", to="X"),
        "up_axis_number": changed(one, "up_axis", to=2),
        "meters_per_unit_zero": changed(one, "meters_per_unit", to=0),
        "meters_per_unit_negative": changed(one, "meters_per_unit", to=-0.01),
        "meters_per_unit_text": changed(one, "meters_per_unit", to="1"),
        "frames_per_second_zero": changed(one, "frames_per_second", to=0),
        "frames_per_second_null": changed(one, "frames_per_second", to=None),
        "octahedra_misspelled": {**one, "octohedra": []},
        "creases_misspelled": {**changed(one, "creases", to=DELETE), "crease": []},
        "vertices_capital": {**one, "Vertices": []},
        "values_misspelled": changed(one, "forms", 0, "value", to=[]),
        "vertices_object": changed(one, "vertices", to={}),
        "vertices_null": changed(one, "vertices", to=None),
        "vertices_flat": changed(one, "vertices", to=[0, 0, 0, 1, 0, 0]),
        "vertex_text": changed(one, "vertices", 1, to=[1, "0", 0]),
        "vertex_null": changed(one, "vertices", 1, to=None),
        "tetrahedra_text": changed(one, "tetrahedra", to="0 1 2 3"),
        "tetrahedra_flat": changed(one, "tetrahedra", to=[0, 1, 2, 3]),
        "tetrahedra_too_deep": changed(one, "tetrahedra", to=[[[0, 1, 2, 3]]]),
        "octahedra_object": {**one, "octahedra": {"0": [0, 1, 2, 3, 4, 5]}},
        "octahedra_true": {**one, "octahedra": True},
        "creases_number": changed(one, "creases", to=1),
        "corners_rows": changed(one, "corners", to=[[3]]),
        "corners_text": changed(one, "corners", to="3"),
        "forms_object": changed(one, "forms", to=flux()),
        "forms_null": changed(one, "forms", to=None),
        "forms_numbers": changed(one, "forms", to=[1, 2]),
        "forms_rows": changed(one, "forms", to=[[1, 2]]),
    }


def broken_roots():
    return {"root_array": "[]\n", "root_number": "1\n", "root_text": '"octet"\n',
            "root_null": "null\n", "root_true": "true\n"}


def broken_meshes():
    one, eight, oct_ = tetrahedron(), star(), octahedron()
    return {
        "coordinates_two": changed(one, "vertices", 2, to=[0, 1]),
        "coordinates_four": changed(one, "vertices", 2, to=[0, 1, 0, 1]),
        "coordinates_none": changed(one, "vertices", 2, to=[]),
        "coordinate_1e300": changed(one, "vertices", 2, 1, to=1e300),
        "tetrahedron_of_three": changed(eight, "tetrahedra", 5, to=[0, 1, 2]),
        "tetrahedron_of_five": changed(eight, "tetrahedra", 5, to=[0, 1, 2, 3, 4]),
        "octahedron_of_five": changed(oct_, "octahedra", 0, to=[0, 1, 2, 3, 4]),
        "index_negative": changed(eight, "tetrahedra", 5, 2, to=-1),
        "index_fractional": changed(eight, "tetrahedra", 5, 2, to=1.5),
        "index_huge": changed(eight, "tetrahedra", 5, 2, to=10**18),
        "index_beyond_32_bits": changed(eight, "tetrahedra", 5, 2, to=2**32 + 1),
        "index_beyond_64_bits": changed(eight, "tetrahedra", 5, 2, to=2**64 + 1),
        "index_1e300": changed(eight, "tetrahedra", 5, 2, to=1e300),
        "tetrahedron_out_of_range": changed(eight, "tetrahedra", 5, 2, to=7),
        "octahedron_out_of_range": changed(oct_, "octahedra", 0, 5, to=6),
        "crease_out_of_range": changed(one, "creases", 0, to=[0, 4]),
        "corner_out_of_range": changed(one, "corners", to=[3, 4]),
        "corner_negative": changed(one, "corners", to=[-1]),
        "tetrahedron_vertex_twice": changed(eight, "tetrahedra", 5, to=[6, 5, 2, 2]),
        "octahedron_vertex_twice": changed(oct_, "octahedra", 0, to=[0, 1, 2, 3, 4, 0]),
        "crease_vertex_twice": changed(one, "creases", 0, to=[1, 1]),
        "crease_no_edge": {**eight, "creases": [[1, 2], [1, 3]]},
        "crease_inside": {**eight, "creases": [[1, 2], [1, 6]]},
        "crease_of_three": {**eight, "creases": [[0, 1, 2]]},
        "corner_inside": {**eight, "corners": [0, 6]},
        "corner_of_no_cell": {**changed(one, "vertices", to=one["vertices"] + [[2, 2, 2]]),
                              "corners": [4]},
    }


def degenerate_cells():
    one, oct_ = tetrahedron(), octahedron()
    ring = oct_["vertices"]
    return {
        "tetrahedron_flat": changed(one, "vertices", 3, to=[0.3, 0.3, 0]),
        "tetrahedron_nearly_flat": changed(one, "vertices", 3, to=[0.3, 0.3, 1e-15]),
        "tetrahedron_zero_edge": changed(one, "vertices", 3, to=[1, 0, 0]),
        "tetrahedron_a_point": changed(one, "vertices", to=[[1, 1, 1]] * 4),
        "tetrahedron_tiny": changed(one, "vertices",
                                    to=[[x * 1e-100 for x in v] for v in one["vertices"]]),
        "octahedron_flat": changed(oct_, "vertices", to=[[x, y, 0] for x, y, z in ring]),
        "octahedron_zero_edge": changed(oct_, "vertices", 2, to=[1, 0, 0]),
        "octahedron_flat_facet": changed(oct_, "vertices", 2, to=[0.5, 0, 0.5]),
        "octahedron_poles_at_one_place": changed(oct_, "vertices", 5, to=[0, 0, 1]),
        "octahedron_inside_out": changed(oct_, "octahedra", 0, to=[0, 1, 3, 2, 4, 5]),
    }


def overlapping_cells():
    base = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 1]]
    # Two splinters, along x and along y, that cross far from their vertices and centroids.
    splinter = [[0, 0, 0], [10, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]
    across = [[8 + y, x - 2, z - 0.005] for x, y, z in splinter]
    small = [[0.2 + x / 10, 0.2 + y / 10, 0.1 + z / 10] for x, y, z in base]
    beside = [[x + 0.3, y + 0.1, z - 0.3] for x, y, z in base]
    eight, oct_ = star(), octahedron()
    return {
        "overlap_folded_at_facet": tetrahedra(base + [[0.3, 0.3, 0.5]],
                                              [[0, 1, 2, 3], [0, 1, 2, 4]]),
        "overlap_octahedron_and_tetrahedron": {
            **changed(oct_, "vertices", to=oct_["vertices"] + [[0, 0, 0]]),
            "tetrahedra": [[0, 1, 2, 6]]},
        "overlap_apart": tetrahedra(base + beside, [[0, 1, 2, 3], [4, 5, 6, 7]]),
        "overlap_one_inside": tetrahedra(base + small, [[0, 1, 2, 3], [4, 5, 6, 7]]),
        "overlap_splinters": tetrahedra(splinter + across, [[0, 1, 2, 3], [4, 5, 6, 7]]),
        "overlap_at_vertex": tetrahedra(base + [[1, 0.9, 1], [0.9, 1, 1], [1, 1, 0.8]],
                                        [[0, 1, 2, 3], [0, 4, 5, 6]]),
        "overlap_at_edge": tetrahedra(base + [[0.3, 0.4, 0.5], [0.3, 0.3, 1.5]],
                                      [[0, 1, 2, 3], [0, 1, 4, 5]]),
        "overlap_octahedra": {
            "octet": 1,
            "vertices": oct_["vertices"] + [[x + 0.9, y, z] for x, y, z in oct_["vertices"]],
            "octahedra": [[0, 1, 2, 3, 4, 5], [6, 7, 8, 9, 10, 11]]},
        "overlap_same_points": tetrahedra(base + base, [[0, 1, 2, 3], [4, 5, 6, 7]]),
        "facet_of_three_cells": tetrahedra(base + [[0.3, 0.3, -1], [0.3, 0.3, 2]],
                                           [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 2, 5]]),
        "tetrahedron_listed_twice": {**eight, "tetrahedra": eight["tetrahedra"] + [[6, 0, 2, 3]]},
        "tetrahedron_listed_twice_reversed": {
            **eight, "tetrahedra": eight["tetrahedra"] + [[6, 0, 3, 2]]},
        "octahedron_listed_twice": {**oct_, "octahedra": [[0, 1, 2, 3, 4, 5], [1, 0, 4, 5, 2, 3]]},
    }


def broken_forms():
    one, moving, eight, oct_ = tetrahedron(), animated(), star(), octahedron()
    two = [flux(), {**flux(), "name": "other"}]
    return {
        "form_no_name": changed(one, "forms", 0, "name", to=DELETE),
        "form_name_empty": changed(one, "forms", 0, "name", to=""),
        "form_name_number": changed(one, "forms", 0, "name", to=7),
        "form_name_twice": {**one, "forms": two + [flux()]},
        "form_name_line_break": changed(one, "forms", 0, "name", to="vel\nocity"),
        "form_name_zero_byte": changed(one, "forms", 0, "name", to="vel\0ocity"),
        "degree_missing": changed(one, "forms", 0, "degree", to=DELETE),
        "degree_4": changed(one, "forms", 0, "degree", to=4),
        "degree_negative": changed(one, "forms", 0, "degree", to=-1),
        "degree_fractional": changed(one, "forms", 0, "degree", to=1.5),
        "degree_text": changed(one, "forms", 0, "degree", to="two"),
        "degree_list": changed(one, "forms", 0, "degree", to=[2]),
        "unit_number": changed(one, "forms", 0, "unit", to=1),
        "simplices_missing": changed(one, "forms", 0, "simplices", to=DELETE),
        "simplices_text": changed(one, "forms", 0, "simplices", to="0 1 2"),
        "simplices_flat": changed(one, "forms", 0, "simplices", to=[0, 1]),
        "simplex_of_two_for_degree_2": changed(one, "forms", 0, "simplices", 1, to=[0, 1]),
        "simplex_of_five_for_degree_3": with_form(eight, 3, [[6, 0, 1, 2, 3]]),
        "simplex_negative": changed(one, "forms", 0, "simplices", 1, to=[0, 1, -3]),
        "simplex_fractional": changed(one, "forms", 0, "simplices", 1, to=[0, 1, 2.5]),
        "simplex_out_of_range": changed(one, "forms", 0, "simplices", 1, to=[0, 1, 4]),
        "simplex_vertex_out_of_range": with_form(one, 0, [[0], [4]]),
        "simplex_cell_out_of_range": with_form(eight, 3, [[7, 0, 1, 2]]),
        "simplex_vertex_twice": changed(one, "forms", 0, "simplices", 1, to=[0, 1, 1]),
        "simplex_no_edge": with_form(eight, 1, [[0, 1], [0, 5]]),
        "simplex_no_edge_axis_of_octahedron": with_form(oct_, 1, [[0, 1], [0, 5]]),
        "simplex_no_facet": with_form(eight, 2, [[0, 1, 2], [0, 1, 3]]),
        "simplex_no_cell": with_form(eight, 3, [[6, 0, 1, 2], [6, 0, 1, 5]]),
        "simplex_cell_in_other_order": with_form(eight, 3, [[6, 0, 1, 2], [0, 6, 2, 3]]),
        "simplex_octahedron_in_other_order": with_form(oct_, 3, [[5, 1, 2, 3, 4, 0]]),
        "simplex_twice_vertex": with_form(one, 0, [[0], [1], [0]]),
        "simplex_twice_edge": with_form(one, 1, [[0, 1], [1, 2], [0, 1]]),
        "simplex_twice_edge_reversed": with_form(one, 1, [[0, 1], [1, 2], [1, 0]]),
        "simplex_twice_facet": with_form(one, 2, [[0, 1, 2], [0, 1, 3], [1, 2, 0]]),
        "simplex_twice_facet_reversed": with_form(one, 2, [[0, 1, 2], [0, 1, 3], [2, 1, 0]]),
        "simplex_twice_cell": with_form(one, 3, [[0, 1, 2, 3], [0, 1, 2, 3]]),
        "values_and_frames": changed(one, "forms", 0, "frames", to={"1": [1.0, 2.0]}),
        "values_nor_frames": changed(one, "forms", 0, "values", to=DELETE),
        "values_too_few": changed(one, "forms", 0, "values", to=[1.0]),
        "values_too_many": changed(one, "forms", 0, "values", to=[1.0, 2.0, 3.0]),
        "values_empty": changed(one, "forms", 0, "values", to=[]),
        "values_number": changed(one, "forms", 0, "values", to=1),
        "values_object": changed(one, "forms", 0, "values", to={"0": 1}),
        "values_rows": changed(one, "forms", 0, "values", to=[[1.0], [2.0]]),
        "values_with_text": changed(one, "forms", 0, "values", to=[1.0, "2"]),
        "values_with_null": changed(one, "forms", 0, "values", to=[None, 1.0]),
        "value_1e300": changed(one, "forms", 0, "values", 1, to=-1e300),
        "value_nan": changed(one, "forms", 0, "values", 1, to=NAN),
        "frames_list": changed(moving, "forms", 0, "frames", to=[[1.0, 2.0]]),
        "frames_null": changed(moving, "forms", 0, "frames", to=None),
        "frames_empty": changed(moving, "forms", 0, "frames", to={}),
        "frames_too_few_values": changed(moving, "forms", 0, "frames", "2", to=[1.0]),
        "frame_object": changed(moving, "forms", 0, "frames", "2", to={}),
        "frame_number": changed(moving, "forms", 0, "frames", "2", to=2),
        "frame_named_by_text": changed(moving, "forms", 0, "frames", "two", to=[1.0, 2.0]),
        "frame_named_by_fraction": changed(moving, "forms", 0, "frames", "1.5", to=[1.0, 2.0]),
        "frame_named_by_nothing": changed(moving, "forms", 0, "frames", "", to=[1.0, 2.0]),
        "frame_long_before_zero": changed(moving, "forms", 0, "frames", "-10000000", to=[1.0, 2.0]),
        "frame_huge": changed(moving, "forms", 0, "frames", "99999999999", to=[1.0, 2.0]),
        "frame_twice": changed(moving, "forms", 0, "frames", "02", to=[1.0, 2.0]),
        "frame_key_twice": changed(moving, "forms", 0, "frames",
                                   to=Raw('{"1": [1, 2], "1": [3, 4]}')),
    }


def broken_cbor():
    """Files that are no CBOR, or hold what a control asset does not."""
    good = to_cbor(tetrahedron())

    def until(text):
        return good[:good.index(text) + len(text)]

    def coordinate(item):
        return to_cbor(changed(tetrahedron(), "vertices", 3, 0, to=Raw(item)))

    def extra(item):
        return to_cbor({**tetrahedron(), "extra": Raw(item)})

    huge = struct.pack(">Q", 2**62)
    return {
        "cbor_empty": b"",
        "cbor_truncated_in_key": until(b"frames_per"),
        "cbor_truncated_in_head": until(b"vertices"),
        "cbor_truncated_in_number": good[:-3],
        "cbor_truncated_in_array": until(b"tetrahedra") + b"\x81\x84\x00\x01",
        "cbor_truncated_without_break": b"\xbf" + good[1:],
        "cbor_trailing_bytes": good + b"\x00",
        "cbor_root_array": to_cbor([tetrahedron()]),
        "cbor_root_tagged_number": b"\xd9\xd9\xf7\x01",
        "cbor_coordinate_nan": coordinate(b"\xfb" + struct.pack(">d", NAN)),
        "cbor_coordinate_infinite": coordinate(b"\xfb" + struct.pack(">d", INFINITY)),
        "cbor_coordinate_nan_32": coordinate(b"\xfa" + struct.pack(">f", NAN)),
        "cbor_coordinate_infinite_32": coordinate(b"\xfa" + struct.pack(">f", -INFINITY)),
        "cbor_coordinate_nan_16": coordinate(b"\xf9\x7e\x00"),
        "cbor_coordinate_infinite_16": coordinate(b"\xf9\x7c\x00"),
        "cbor_value_nan": to_cbor(changed(tetrahedron(), "forms", 0, "values", 1, to=NAN)),
        "cbor_index_nan": to_cbor(changed(tetrahedron(), "tetrahedra", 0, 1, to=NAN)),
        "cbor_index_below_64_bits": to_cbor(
            changed(tetrahedron(), "tetrahedra", 0, 1, to=-(2**64))),
        "cbor_array_length_huge": extra(b"\x9b" + huge + b"\x01"),
        "cbor_array_length_all_ones": extra(b"\x9b" + b"\xff" * 8 + b"\x01\xff"),
        "cbor_map_length_huge": extra(b"\xbb" + huge + b"\x61a\x01"),
        "cbor_text_length_huge": extra(b"\x7b" + huge + b"text"),
        "cbor_bytes_length_huge": extra(b"\x5b" + huge + b"text"),
        "cbor_bytes": extra(b"\x44\x00\x01\x02\x03"),
        "cbor_length_reserved": extra(b"\x9c\x01"),
        "cbor_text_chunk_number": extra(b"\x7f\x01\xff"),
        "cbor_text_chunk_nested": extra(b"\x7f\x7f\x61a\xff\xff"),
        "cbor_break_in_counted_array": extra(b"\x82\x01\xff"),
        "cbor_odd_map": extra(b"\xbf\x61a\xff"),
        "cbor_tag": extra(b"\xc2\x41\x01"),
        "cbor_undefined": extra(b"\xf7"),
        "cbor_simple_value": extra(b"\xf8\xff"),
        "cbor_key_number": extra(b"\xa1\x01\x02"),
        "cbor_key_twice": extra(b"\xa2\x61a\x01\x61a\x02"),
        "cbor_name_not_utf8": to_cbor({**tetrahedron(), "name": Raw(b"\x63\xe9\xe8t")}),
        "cbor_nested_deeply": extra(b"\x81" * 100 + b"\x01"),
        "cbor_nested_deeply_maps": extra(b"\xa1\x61a" * 100 + b"\x01"),
        "binary_garbage": bytes((167 * k * k + 61 * k + 211) % 256 for k in range(300)),
        "binary_png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
        "binary_zeros": b"\0" * 64,
        "binary_ones": b"\xff" * 64,
    }


def json_files():
    files = {**broken_text(), **broken_roots()}
    for group in (broken_documents, broken_meshes, degenerate_cells, overlapping_cells,
                  broken_forms):
        files.update({name: to_json(document) for name, document in group().items()})
    return {f"{name}.octet.json": content if isinstance(content, bytes) else content.encode()
            for name, content in files.items()}


def cbor_files():
    return {f"{name}.octet": content for name, content in broken_cbor().items()}


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent)
    for name, content in {**json_files(), **cbor_files()}.items():
        (folder / name).write_bytes(content)


if __name__ == "__main__":
    main()
