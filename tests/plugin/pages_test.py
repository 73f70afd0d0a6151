#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: their commands run, the command line's reference is what the command
itself prints, the asset that the format's page shows is one, and each page is one step from README.md.
Arguments: the octetvdb command.

    pages_test.py OCTETVDB --write    puts the reference into plugin/cli/README.md"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

import command

OCTETVDB = command.from_arguments()
ROOT = os.path.abspath(os.path.join(command.SAMPLES, ".."))
REFERENCE = "plugin/cli/README.md"
MARK = "<!-- Below: octetvdb --reference markdown. -->\n"
# Pages whose lines that begin with "octetvdb" are run, in their order.
PAGES = ["README.md", REFERENCE, "samples/cages/README.md"]
# One page each: what a newcomer looks for.
TOPICS = {"converters/README.md", "plugin/cli/README.md", "plugin/python/README.md",
          "samples/blender/README.md", "samples/farm/README.md", "core/README.md",
          "samples/tutorials/README.md", "core/SCHEME.md"}
# A tetrahedron as a surface, and a curve inside it.
PART = "solid part\n" + "".join(
    "facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in facet)
    + "endloop\nendfacet\n"
    for facet in (((0, 0, 0), (0, 1, 0), (1, 0, 0)), ((0, 0, 0), (1, 0, 0), (0, 0, 1)),
                  ((0, 0, 0), (0, 0, 1), (0, 1, 0)), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))) + "endsolid\n"
CURVE = "v 0.1 0.2 0.2\nv 0.2 0.3 0.2\nv 0.3 0.2 0.3\nl 1 2 3\n"


def read(page):
    with open(os.path.join(ROOT, page)) as file:
        return file.read()


def commands(page):
    """Indented command lines of a page: of octetvdb, and scripts that make what it takes."""
    text = re.sub(r"\\\n\s*", "", read(page).partition(MARK)[0])
    return [line.strip() for line in text.splitlines()
            if re.match(r"    (octetvdb (?!COMMAND)|python3 samples/)", line)]


class Pages(unittest.TestCase):
    def test_their_commands_run(self):
        for page in PAGES:
            found = commands(page)
            self.assertGreater(len(found), 0, page)
            with tempfile.TemporaryDirectory() as folder:
                os.symlink(os.path.join(ROOT, "samples"), os.path.join(folder, "samples"))
                os.mkdir(os.path.join(folder, "out"))
                for name, content in (("part.stl", PART), ("curves.obj", CURVE)):
                    with open(os.path.join(folder, name), "w") as file:
                        file.write(content)
                path = f"{os.path.dirname(OCTETVDB.path)}:/usr/bin:/bin"
                for line in found:
                    with self.subTest(page=page, command=line):
                        done = subprocess.run(["bash", "-c", line], cwd=folder, capture_output=True,
                                              text=True, env={**os.environ, "PATH": path})
                        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_reference_is_the_command_s(self):
        _, mark, below = read(REFERENCE).partition(MARK)
        self.assertTrue(mark)
        printed = OCTETVDB.run("--reference", "markdown").stdout
        self.assertEqual(below.strip(), printed.strip(), "out of date: see the head of this file")

    def test_the_asset_that_is_shown_is_one(self):
        block, = re.findall(r"```json\n(.*?)```", read("converters/README.md"), re.S)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "shown.octet.json")
            with open(path, "w") as file:
                file.write(block)
            done = OCTETVDB.run("info", path)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("name: vortex", done.stdout)

    def test_all_pages_are_one_step_from_the_first(self):
        links = set(re.findall(r"\]\(([^)#\s]+)", read("README.md")))
        self.assertEqual(TOPICS - links, set())

    def test_the_first_screen_says_what_and_shows_it(self):
        self.assertRegex("\n".join(read("README.md").splitlines()[:14]), r"!\[.*\]\(.*\.png\)")


def write():
    above, _, _ = read(REFERENCE).partition(MARK)
    printed = OCTETVDB.run("--reference", "markdown").stdout
    with open(os.path.join(ROOT, REFERENCE), "w") as file:
        file.write(above.rstrip() + "\n\n" + MARK + "\n" + printed.rstrip() + "\n")


if __name__ == "__main__":
    if "--write" in sys.argv:
        write()
    else:
        unittest.main()
