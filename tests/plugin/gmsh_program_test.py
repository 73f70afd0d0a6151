#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""octetvdb and octetvdb-gmsh: only the latter holds code under the GPL; without it octetvdb says what
to do; and neither trusts the other's messages. Arguments: the octetvdb command, the Python module,
the add-on's zip.
"""
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
import unittest
import zipfile

ZIP = sys.argv.pop()
MODULE = sys.argv.pop()
OCTETVDB = sys.argv.pop()
PROGRAM = os.path.join(os.path.dirname(OCTETVDB), "octetvdb-gmsh")
MESH = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../data/gmsh/two_tets_41.msh")
FILL = ("fill", "--box", "0", "0", "0", "1", "1", "1", "--cells", "tetrahedra", "--spacing", "0.5",
        "-o")
# messages.h
MARK, VERSION, HEAD = 0x534d474f, 1, struct.Struct("=IIIQ")
HELLO, READ_MESH, PROGRESS, ANSWER, FAILURE = 0, 1, 6, 7, 8


def message(kind, content=b"", version=VERSION):
    return HEAD.pack(MARK, version, kind, len(content)) + content


def messages(data):
    """Kinds and contents of whole messages."""
    result = []
    while data:
        mark, version, kind, size = HEAD.unpack_from(data)
        assert (mark, version) == (MARK, VERSION) and len(data) >= HEAD.size + size
        result.append((kind, data[HEAD.size:HEAD.size + size]))
        data = data[HEAD.size + size:]
    return result


class Licences(unittest.TestCase):
    def test_command_and_module_hold_no_gpl_code(self):
        for file in (OCTETVDB, MODULE):
            needed = subprocess.run(["readelf", "-d", file], check=True, capture_output=True,
                                    text=True).stdout
            self.assertIn("libtbb", needed)
            self.assertIsNone(re.search(r"lib(gmsh|gmp|mpfr|CGAL)", needed), needed)
            with open(file, "rb") as content:
                content = content.read()
            for word in (b"gmshInitialize", b"Polygon_mesh_processing"):
                self.assertNotIn(word, content, file)

    @unittest.skipUnless(os.path.exists(PROGRAM), "without octetvdb-gmsh")
    def test_program_says_its_licence(self):
        done = subprocess.run([PROGRAM, "--version"], check=True, capture_output=True, text=True)
        self.assertIn("under the GPL 3 or later", done.stdout)
        done = subprocess.run([PROGRAM], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (2, ""))

    def test_addon_says_the_licences_of_what_is_in_it(self):
        with zipfile.ZipFile(ZIP) as file:
            names = set(file.namelist())
            manifest = tomllib.loads(file.read("octetvdb_addon/blender_manifest.toml").decode())
        expected = ["SPDX:Apache-2.0"]
        self.assertIn("octetvdb_addon/LICENSE", names)
        if "octetvdb_addon/octetvdb/octetvdb-gmsh" in names:
            expected.append("SPDX:GPL-3.0-or-later")
            self.assertIn("octetvdb_addon/COPYING.octetvdb-gmsh", names)
        self.assertEqual(manifest["license"], expected)
        self.assertEqual("octetvdb_addon/octetvdb/octetvdb-gmsh" in names, os.path.exists(PROGRAM))


class Elsewhere(unittest.TestCase):
    """The command in a folder of its own, where a test puts an octetvdb-gmsh of its own, or none."""

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="octetvdb gmsh ")
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        self.octetvdb = shutil.copy(OCTETVDB, self.folder)

    def fake(self, script, folder=None):
        path = os.path.join(folder or self.folder, "octetvdb-gmsh")
        with open(path, "w") as file:
            file.write("#!/bin/sh\n" + script)
        os.chmod(path, 0o755)

    def speaking(self, data, then=""):
        """A program that says some bytes."""
        said = os.path.join(self.folder, "said")
        with open(said, "wb") as file:
            file.write(data)
        self.fake(f"cat '{said}'\n{then}")

    def run_it(self, *arguments, path="/usr/bin:/bin", cwd=None):
        return subprocess.run([self.octetvdb, *arguments], capture_output=True, text=True, cwd=cwd,
                              env={**os.environ, "PATH": path}, timeout=60)

    def refused(self, status, words, *arguments, **options):
        out = os.path.join(self.folder, "cage.octet")
        done = self.run_it(*(arguments or (*FILL, out)), **options)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
        self.assertIn(words, done.stderr)
        self.assertFalse(os.path.exists(out))

    def test_without_it_the_error_says_what_to_do(self):
        for arguments in ((), ("info", MESH)):
            self.refused(1, "octetvdb-gmsh: is not installed", *arguments)
            self.refused(1, "OCTETVDB_WITH_GMSH=ON", *arguments)
        # What an error of the mesh is needs no Gmsh.
        bad = os.path.join(self.folder, "bad.msh")
        with open(bad, "w") as file:
            file.write("nothing")
        self.refused(2, "bad.msh: line 1", "info", bad)

    @unittest.skipUnless(os.path.exists(PROGRAM), "without octetvdb-gmsh")
    def test_it_is_found_on_the_path_by_whole_names_only(self):
        folder = os.path.dirname(PROGRAM)
        done = self.run_it("info", MESH, path="/absent::" + folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        for path in (".", "", ":"):
            self.refused(1, "is not installed", "info", os.path.abspath(MESH), path=path, cwd=folder)

    def test_what_cannot_run_or_does_not_belong_is_told(self):
        self.fake("exit 3")
        self.refused(1, "cannot be run: it ended early (exit status 3)")
        self.fake("kill -SEGV $$")
        self.refused(1, "cannot be run: it crashed (signal 11)")
        self.fake("echo a program that talks of something else")
        self.refused(1, "does not belong to this octetvdb: its message is none")
        self.speaking(message(HELLO, version=9))
        self.refused(1, "its message is of version 9 instead of 1")

    def test_what_goes_wrong_at_work_is_told(self):
        hello = message(HELLO)
        for said, then, words in (
                (hello, "kill -SEGV $$", "CGAL crashed (signal 11) cleaning it"),
                (hello, "", "CGAL ended early cleaning it"),
                (hello + message(ANSWER, b"x" * 100)[:50], "", "CGAL ended early cleaning it"),
                (hello + message(ANSWER, b"no surface"), "", "CGAL failed cleaning it"),
                (hello + message(99), "", "CGAL failed cleaning it"),
                (hello + b"Segmentation fault " * 3, "", "CGAL failed cleaning it"),
                (hello + message(PROGRESS, b"1"), "", "CGAL failed cleaning it"),
                # One vertex, and a triangle that has others.
                (hello + message(ANSWER, struct.pack("=Q3dQ3i", 1, 0, 0, 0, 1, 0, 1, 2)), "",
                 "CGAL failed: a triangle has no such vertex")):
            self.speaking(said, then)
            self.refused(2, words)
        self.speaking(hello + message(FAILURE, struct.pack("=BQ7sQ6s", 1, 7, b"spacing", 6,
                                                           b"is odd")))
        self.refused(2, "--spacing: is odd")
        self.speaking(hello, "kill -SEGV $$")
        self.refused(2, "Gmsh crashed (signal 11) reading it: it is damaged", "info", MESH)

    def test_ctrl_c_ends_one_that_hangs(self):
        self.speaking(message(HELLO), "trap '' INT TERM\nwhile :; do sleep 0.05; done")
        out = os.path.join(self.folder, "cage.octet")
        process = subprocess.Popen([self.octetvdb, *FILL, out], stderr=subprocess.PIPE, text=True)
        time.sleep(1)
        start = time.monotonic()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
        self.assertLess(time.monotonic() - start, 1)  # 0.1 s on a machine at rest
        self.assertEqual((process.returncode, errors), (130, "octetvdb: cancelled\n"))


@unittest.skipUnless(os.path.exists(PROGRAM), "without octetvdb-gmsh")
class Requests(unittest.TestCase):
    def answers(self, data):
        done = subprocess.run([PROGRAM, "serve"], input=data, stdout=subprocess.PIPE, timeout=60)
        return done.returncode, messages(done.stdout)

    def test_malformed_ones_are_refused(self):
        path = MESH.encode()
        good = message(READ_MESH, struct.pack(f"=Q{len(path)}sQ", len(path), path, 1 << 30))
        self.assertEqual(self.answers(good)[1][1][0], ANSWER)
        for data, words in ((b"", b"is cut off"), (good[:-1], b"is cut off"),
                            (b"GET / HTTP/1.1 and more of it", b"is none"),
                            (message(ANSWER), b"is no request"), (message(77), b"unknown kind"),
                            (message(READ_MESH, version=0), b"of version 0 instead of 1"),
                            (message(READ_MESH, b"\xff" * 8), b"is cut off"),
                            (message(READ_MESH, good[HEAD.size:] + b"!"), b"after its end")):
            status, said = self.answers(data)
            self.assertEqual((status, [kind for kind, _ in said]), (1, [HELLO, FAILURE]), data)
            self.assertIn(words, said[1][1])

    def test_memory_is_limited(self):
        path = MESH.encode()
        status, said = self.answers(
            message(READ_MESH, struct.pack(f"=Q{len(path)}sQ", len(path), path, 1 << 20)))
        self.assertEqual((status, said[-1][0]), (1, FAILURE))
        self.assertIn(b"the Gmsh library", said[-1][1])


if __name__ == "__main__":
    unittest.main()
