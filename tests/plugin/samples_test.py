#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Samples: their scripts make the assets that are stored, and they bake to what their READMEs say.
Arguments: the octetvdb command.
"""
import glob
import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples")
NAMES = sorted(os.path.basename(os.path.dirname(p)) for p in glob.glob(f"{SAMPLES}/*/make.py"))
# Another Gmsh makes another mesh.
GMSH_OF_BALL = "4.8.4"
# READMEs print four digits.
PRINTED = 2e-4
NUMBER = re.compile(r"[-+]?\d[\d,]*\.?\d*(?:e[-+]?\d+)?")


def load(path):
    with open(path) as file:
        return json.load(file)


def gmsh_version():
    try:
        import gmsh
    except ImportError:
        return None
    gmsh.initialize()
    version = gmsh.option.getString("General.Version")
    gmsh.finalize()
    return version


def import_script(path):
    spec = importlib.util.spec_from_file_location("make", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def expectation(readme):
    """The first command in a README and the lines quoted after it, which its output must have."""
    with open(readme) as file:
        blocks = re.findall(r"(?:^    .*\n)+", file.read(), re.MULTILINE)
    command, output = ([line[4:] for line in block.splitlines()] for block in blocks[:2])
    words = shlex.split(command[0])
    assert words[0] == "samples/bake.sh", command
    return words[1], words[2:], output


def same_line(got, want):
    """The same words, and the same numbers to their printed digits."""
    if NUMBER.sub("#", got) != NUMBER.sub("#", want):
        return False
    for a, b in zip(NUMBER.findall(got), NUMBER.findall(want)):
        a, b = float(a.replace(",", "")), float(b.replace(",", ""))
        if abs(a - b) > PRINTED * max(abs(a), abs(b)):
            return False
    return True


class Samples(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def check_equal(self, got, want, where):
        """Equal documents, numbers to rounding: a few last digits depend on the C library."""
        if isinstance(want, float):
            self.assertAlmostEqual(got, want, delta=1e-13 * max(1, abs(want)), msg=where)
        elif isinstance(want, list):
            self.assertEqual(len(got), len(want), where)
            for k, (a, b) in enumerate(zip(got, want)):
                self.check_equal(a, b, f"{where}[{k}]")
        elif isinstance(want, dict):
            self.assertEqual(list(got), list(want), where)
            for key in want:
                self.check_equal(got[key], want[key], f"{where}.{key}")
        else:
            self.assertEqual(got, want, where)

    def test_there_are_samples(self):
        self.assertEqual(NAMES, ["animated", "ball", "box", "lattice", "thesis"])

    def test_scripts_make_the_stored_assets(self):
        copy = os.path.join(self.folder.name, "samples")
        shutil.copytree(SAMPLES, copy)
        for name in NAMES:
            with self.subTest(sample=name):
                stored = glob.glob(f"{SAMPLES}/{name}/*.octet.json")
                self.assertTrue(stored)
                for path in stored:
                    os.remove(os.path.join(copy, name, os.path.basename(path)))
                script = os.path.join(copy, name, "make.py")
                if name == "ball" and gmsh_version() != GMSH_OF_BALL:
                    # The coefficients, at least, on the mesh that is stored.
                    asset = load(stored[0])
                    import_script(script).write(os.path.join(copy, name, "ball.octet.json"),
                                                asset["vertices"], asset["tetrahedra"])
                else:
                    subprocess.run([sys.executable, script], check=True)
                for path in stored:
                    file = os.path.basename(path)
                    self.check_equal(load(os.path.join(copy, name, file)), load(path), file)

    def test_bakes_are_what_the_readmes_say(self):
        for name in NAMES:
            with self.subTest(sample=name):
                sample, options, lines = expectation(f"{SAMPLES}/{name}/README.md")
                self.assertEqual(sample, name)
                output = []
                for asset in sorted(glob.glob(f"{SAMPLES}/{name}/*.octet.json")):
                    out = os.path.basename(asset).replace(".octet.json", ".vdb")
                    os.makedirs(os.path.join(self.folder.name, "out"), exist_ok=True)
                    baked = subprocess.run([OCTETVDB, "bake", asset, "-o", f"out/{out}", *options],
                                           capture_output=True, text=True, cwd=self.folder.name)
                    self.assertEqual(baked.returncode, 0, baked.stderr)
                    output += baked.stdout.splitlines()
                at = 0
                self.assertGreater(len(lines), 2)
                for line in filter(None, lines):
                    at = next((k + 1 for k in range(at, len(output)) if same_line(output[k], line)),
                              None)
                    self.assertIsNotNone(at, f"not printed, or not in this order: {line}\nbut:\n"
                                         + "\n".join(output))

    def test_what_does_not_fit_in_memory_is_refused(self):
        out = os.path.join(self.folder.name, "box.vdb")
        bake = subprocess.run([OCTETVDB, "bake", f"{SAMPLES}/box/box.octet.json", "-o", out,
                               "--resolution", "50000"], capture_output=True, text=True)
        self.assertEqual(bake.returncode, 33, bake.stderr)
        self.assertRegex(bake.stderr, r"resolution: .* memory; there are [\d.]+ GB; "
                                       r"the largest resolution that fits is \d+")
        self.assertEqual(os.listdir(self.folder.name), [])


if __name__ == "__main__":
    unittest.main()
