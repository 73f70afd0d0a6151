#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rooms know only rooms below them: reads the includes of core and converters.

Argument: the repository's folder. An include that is refused here wants its declaration moved to a
lower room, not a place in the list.
"""
import os
import re
import sys
import unittest

ROOT = os.path.abspath(sys.argv.pop(1))
# Rooms of core, from below. Each may include itself and those of the lines before its own.
LAYERS = [
    ["base"],
    ["geometry", "rules"],
    ["topology"],
    ["forms", "cage"],
    ["primitives", "refine"],
    ["field", "analysis"],
    ["hodge", "streamlines"],
    ["fit", "raster"],
    ["thesis"],
]
API = os.path.join("core", "api.h")  # names the public headers of all
LEVEL = {room: level for level, rooms in enumerate(LAYERS) for room in rooms}
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]', re.M)
# What a part of the repository never includes, and why.
REFUSED = {
    "core": (r"openvdb/|octet/(converters|plugin)/|nlohmann/", "mathematics without file formats"),
    "converters": (r"octet/(plugin|core/thesis)/|plugin/|CLI/|pybind11/",
                   "formats without a program around them, or a rule of their own"),
}


def sources(folder):
    for path, _, names in os.walk(os.path.join(ROOT, folder)):
        for name in sorted(names):
            if name.endswith((".h", ".cpp")):
                yield os.path.join(path, name)


def includes(file):
    """What a file includes: the repository's own as paths from its root, others as they stand."""
    with open(file, encoding="utf-8") as text:
        found = INCLUDE.findall(text.read())
    for kind, name in found:
        own = os.path.normpath(os.path.join(os.path.dirname(file), name))
        yield os.path.relpath(own, ROOT) if kind == '"' and os.path.exists(own) else name


def room(path):
    """The room of a path such as core/topology/split.h or octet/core/topology/split.h."""
    parts = path.split("/")
    if parts[0] == "octet":
        parts = parts[1:]
    return parts[1] if parts[0] == "core" and len(parts) == 3 else None


def arrows():
    """(room, room it includes) -> one file that does, of core."""
    found = {}
    for file in sources("core"):
        path = os.path.relpath(file, ROOT)
        if path == API:
            continue
        for name in includes(file):
            if room(name) not in (None, room(path)):
                found.setdefault((room(path), room(name)), f"{path} includes {name}")
    return found


class Rooms(unittest.TestCase):
    def test_includes_are_found(self):
        """Else nothing would be tested."""
        self.assertIn(("topology", "base"), arrows())
        self.assertIn(("fit", "refine"), arrows())

    def test_every_room_of_core_stands_in_a_layer(self):
        files = {os.path.relpath(file, ROOT) for file in sources("core")} - {API}
        rooms = {room(file) for file in files}
        self.assertLessEqual(rooms, set(LEVEL))

    def test_rooms_include_lower_rooms_only(self):
        upward = [where for (above, below), where in arrows().items() if LEVEL[below] >= LEVEL[above]]
        self.assertEqual(upward, [])

    def test_core_and_converters_know_nothing_of_what_is_around_them(self):
        for folder, (pattern, why) in REFUSED.items():
            for file in sources(folder):
                for name in includes(file):
                    with self.subTest(file=os.path.relpath(file, ROOT), includes=name):
                        self.assertIsNone(re.match(pattern, name), why)


unittest.main()
