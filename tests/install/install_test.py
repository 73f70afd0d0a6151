#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The installed package: a project elsewhere finds, builds with and runs it.

Arguments: the build tree, the C++ compiler.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import pyopenvdb as vdb

COMPILER = sys.argv.pop()
BUILD = sys.argv.pop()
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")


def run(*command):
    result = subprocess.run(command, capture_output=True, text=True)
    if result.returncode != 0:
        raise AssertionError(" ".join(command) + "\n" + result.stdout + result.stderr)
    return result.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="octetvdb install ")  # a space, too
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = cls.temporary.name
        # Installed in one place and moved to another: nothing in it may know where it was.
        first = os.path.join(cls.folder, "first")
        cls.prefix = os.path.join(cls.folder, "prefix")
        run("cmake", "--install", BUILD, "--prefix", first)
        os.rename(first, cls.prefix)
        shutil.copytree(os.path.join(HERE, "consumer"), os.path.join(cls.folder, "project"))

    def consumer(self, *options):
        """Configures and builds the project, and returns the program."""
        tree = os.path.join(self.folder, "build" + "".join(options))
        run("cmake", "-G", "Ninja", "-S", os.path.join(self.folder, "project"), "-B", tree,
            "-DCMAKE_PREFIX_PATH=" + self.prefix, "-DCMAKE_CXX_COMPILER=" + COMPILER,
            "-DCMAKE_BUILD_TYPE=Debug", *options)
        run("cmake", "--build", tree)
        return os.path.join(tree, "consumer")

    def test_consumer_refines_and_bakes(self):
        out = os.path.join(self.folder, "out.vdb")
        mesh = os.path.join(ROOT, "tests", "data", "gmsh", "two_tets_41.msh")
        # Of a program elsewhere, octetvdb-gmsh is found on the PATH.
        with_gmsh = os.path.exists(self.path("bin", "octetvdb-gmsh"))
        lines = run("env", f"PATH={self.path('bin')}:{os.environ['PATH']}", self.consumer(),
                    os.path.join(ROOT, "samples", "box", "box.octet.json"), out,
                    *([mesh] if with_gmsh else [])).splitlines()
        version, inside, speed, grids = lines[0].split()
        self.assertEqual(run(self.path("bin", "octetvdb"), "--version"), version + "\n")
        self.assertEqual((inside, grids), ("1", "2"))
        self.assertGreater(float(speed), 1e-3)
        self.assertGreater(vdb.read(out, "velocity").activeVoxelCount(), 1000)
        self.assertEqual(lines[1:], ["4"] if with_gmsh else [])

    def test_module_finds_the_gmsh_program_of_its_prefix(self):
        package, = glob.glob(self.path("lib", "python*", "site-packages"))
        script = ("import octetvdb\n"
                  "try: print(len(octetvdb.fill_tetrahedra([[0, 0, 0], [1, 0, 0], [0, 1, 0],"
                  " [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], 0.5).tetrahedra) > 0)\n"
                  "except octetvdb.IoError as e: print(e.reason)")
        with_gmsh = os.path.exists(self.path("bin", "octetvdb-gmsh"))
        said = run("env", "PATH=/usr/bin:/bin", f"PYTHONPATH={package}", sys.executable, "-c", script)
        self.assertTrue(said.startswith("True" if with_gmsh else "is not installed"), said)

    def test_core_alone_needs_no_openvdb(self):
        # A tetrahedron: 4 and 1, then 4 * 4 + 8 and 4 + 6.
        self.assertEqual(run(self.consumer("-DCORE_ONLY=ON")), "34\n")

    def path(self, *names):
        return os.path.join(self.prefix, *names)

    def test_installed_files_know_nothing_of_the_build(self):
        places = [os.path.realpath(p) for p in (BUILD, ROOT)]
        found = 0
        for folder, _, names in os.walk(self.prefix):
            for name in names:
                if not name.endswith((".cmake", ".h", ".py")):
                    continue
                found += 1
                with open(os.path.join(folder, name)) as file:
                    text = file.read()
                for place in (*places, os.path.join(self.folder, "first")):
                    self.assertNotIn(place, text, name)
        self.assertGreater(found, 50)

    def test_what_is_private_stays_at_home(self):
        installed = {name for _, _, names in os.walk(self.path("include")) for name in names}
        self.assertIn("refiner.h", installed)
        self.assertFalse(installed & {"dense_cholesky.h", "refiner_level.h", "cbor_reader.h"})

    def test_installed_headers_need_no_other(self):
        """All of core in one program, in an order that is none of theirs."""
        include = self.path("include")
        headers = []
        for folder, _, names in os.walk(os.path.join(include, "octet", "core")):
            headers += [os.path.relpath(os.path.join(folder, n), include) for n in names]
        self.assertGreater(len(headers), 30)
        source = "".join(f"#include <{h}>\n" for h in sorted(headers, reverse=True))
        result = subprocess.run(
            [COMPILER, "-std=c++17", "-fsyntax-only", "-I", include, "-isystem",
             "/usr/include/eigen3", "-x", "c++", "-"], input=source, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)

    def test_licence_comes_along(self):
        found = [os.path.join(f, n) for f, _, names in os.walk(self.prefix) for n in names
                 if n == "LICENSE"]
        self.assertEqual(len(found), 1)
        with open(found[0]) as file:
            self.assertTrue(re.search(r"Apache License\s+Version 2\.0", file.read()))
        copying = glob.glob(self.path("share", "doc", "*", "COPYING.octetvdb-gmsh"))
        self.assertEqual(bool(copying), os.path.exists(self.path("bin", "octetvdb-gmsh")))


if __name__ == "__main__":
    unittest.main()
