#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bad input: exit code 2, one line with file, place and reason, nothing written, no crash.

Arguments: the octetvdb command, release or built with sanitizers (which end it with another exit code
when they find something). The corpus is tests/data/malformed, and the answers to it answers.txt there,
written by `malformed_test.py OCTETVDB --write-answers` and then read by a person.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

import command

OCTETVDB = command.from_arguments()
CORPUS = os.path.join(command.DATA, "malformed")
ANSWERS = os.path.join(CORPUS, "answers.txt")
GIGABYTE = 1 << 30
NO_FILE = "the answer does not tell the file"


def corpus():
    return sorted(f for f in os.listdir(CORPUS) if ".octet" in f)


def answer(stderr, path):
    """The line without the command's and the file's name; what depends on the parser's version and
    on rounding is left out."""
    start = f"{command.PREFIX}{path}: "
    if not stderr.startswith(start):
        return f"{NO_FILE}: {stderr}"
    text = stderr[len(start):].rstrip("\n")
    text = re.sub(r"^(line \d+, column \d+): .*", r"\1: *", text)
    return re.sub(r"-?\d(\.\d+)?e-\d+", "#", text)


def usual_commands(path, folder):
    """Each of the commands on a bad input, with an output in `folder`."""
    return [("info", path),
            ("bake", path, "-o", os.path.join(folder, "out.vdb"), "--resolution", "4"),
            ("refine", path, "-o", os.path.join(folder, "out.json"), "--levels", "1")]


class Refused(unittest.TestCase):
    def setUp(self):
        temporary = command.temporary_folder()
        self.addCleanup(temporary.cleanup)
        self.inputs = os.path.join(temporary.name, "in")
        self.outputs = os.path.join(temporary.name, "out")
        os.mkdir(self.inputs)
        os.mkdir(self.outputs)

    def tearDown(self):
        self.assertEqual(os.listdir(self.outputs), [], "something was written")

    def write(self, name, content):
        path = os.path.join(self.inputs, name)
        with open(path, "wb") as file:
            file.write(content)
        return path

    def refused(self, arguments, **options):
        """Runs the command and returns what it answered, or None and why it should have been other."""
        result = OCTETVDB.run(*arguments, **options)
        problem = command.complaint(result)
        return (None, problem) if problem else (answer(result.stderr, arguments[1]), None)

    def check_all(self, paths, every_command=True):
        """Every command on each path, or one after the other on one path after the other."""
        def check(path):
            commands = usual_commands(path, self.outputs)
            if not every_command:
                commands = [commands[paths.index(path) % len(commands)]]
            return [(c, *self.refused(c)) for c in commands]

        answers = {}
        for path, results in zip(paths, command.in_parallel(check, paths)):
            for arguments, said, problem in results:
                self.assertIsNone(problem, f"{arguments[0]} {path}")
                self.assertNotIn(NO_FILE, said, f"{arguments[0]} {path}")
                answers.setdefault(path, said)
                self.assertEqual(answers[path], said, "the same whatever the command")
        return answers


class Assets(Refused):
    """Control assets."""

    def test_corpus_is_what_its_script_writes(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, os.path.join(CORPUS, "make.py"), folder], check=True)
            self.assertEqual(sorted(os.listdir(folder)), corpus())
            for name in corpus():
                with open(os.path.join(folder, name), "rb") as made:
                    with open(os.path.join(CORPUS, name), "rb") as kept:
                        self.assertEqual(made.read(), kept.read(), name)

    def test_corpus(self):
        answers = self.check_all([os.path.join(CORPUS, name) for name in corpus()],
                                 every_command=not OCTETVDB.sanitized)
        self.assertGreater(len(answers), 200)
        with open(ANSWERS) as file:
            expected = dict(line.rstrip("\n").split(": ", 1) for line in file if line[0] != "#")
        self.assertEqual({os.path.basename(p): a for p, a in answers.items()}, expected)

    def test_good_asset_cut_off_anywhere(self):
        step = 29 if OCTETVDB.sanitized else 7  # fuzz_replay tries every byte in one process
        for name in ("good.octet.json", "good.octet"):
            with open(os.path.join(command.DATA, "wellformed", name), "rb") as file:
                content = file.read().rstrip()
            self.assertEqual(OCTETVDB.run("info", self.write(name, content)).returncode, 0)
            cuts = list(range(0, len(content), step)) + [len(content) - 1]
            paths = [self.write(f"cut{n}.{name}", content[:n]) for n in cuts]
            for path, said in self.check_all(paths, every_command=False).items():
                self.assertRegex(said, "^(line [0-9]+, column [0-9]+: |byte [0-9]+: |is empty)", path)

    def test_a_gigabyte_of_nesting(self):
        """Made on the way, through a pipe: the answer comes after the first few bytes."""
        mesh = b'{"octet": 1, "vertices": '
        shapes = {"arrays": (mesh, b"["), "objects": (b"", b'{"a":'), "mixed": (b"", b'{"a":[[['),
                  "cbor_arrays": (b"\xa1\x61a", b"\x81"), "cbor_open_arrays": (b"\xbf\x61a", b"\x9f"),
                  "cbor_maps": (b"", b"\xa1\x61a")}
        for name, (start, piece) in shapes.items():
            with self.subTest(name):
                path = os.path.join(self.inputs, name)
                os.mkfifo(path)
                feeder = threading.Thread(target=feed, args=(path, start, piece))
                feeder.start()
                said, problem = self.refused(("info", path))
                feeder.join()
                self.assertIsNone(problem)
                self.assertIn("is nested deeper than 16 levels", said)

    def test_a_gigabyte_of_nesting_in_a_file(self):
        path = self.write("nested.octet.json", b'{"vertices": ')
        with open(path, "ab") as file:
            for _ in range(GIGABYTE >> 20):
                file.write(b"[" * (1 << 20))
        self.assertGreater(os.path.getsize(path), GIGABYTE)
        for said in self.check_all([path]).values():
            self.assertIn("is nested deeper than 16 levels", said)

    def test_millions_of_small_values(self):
        """A file of 30 MB that would take gigabytes as a tree of values."""
        content = b'{"octet": 1, "vertices": [[0, 0, 0]], "extra": [' + b"{}," * 10000000 + b"{}]}"
        said = self.check_all([self.write("many.octet.json", content)], every_command=False)
        self.assertIn("more than a control asset can hold", list(said.values())[0])

    def test_no_such_file_and_no_file(self):
        for path, reason in ((os.path.join(self.inputs, "missing.octet.json"), "cannot be read: No "
                              "such file or directory"), (self.inputs, "is a folder"),
                             ("/dev/null", "is empty")):
            said = self.check_all([path])
            self.assertEqual(said[path], reason)

    @unittest.skipIf(os.geteuid() == 0, "root may read everything")
    def test_file_that_may_not_be_read(self):
        path = self.write("secret.octet.json", b"{}")
        os.chmod(path, 0)
        self.assertIn("Permission denied", self.check_all([path])[path])

    def test_odd_file_names_stay_on_one_line(self):
        for name in ("line\nbreak.octet.json", "tab\t\x1b[31mred.octet.json"):
            result = OCTETVDB.run("info", self.write(name, b"["))
            self.assertIsNone(command.complaint(result))
            self.assertNotIn("\x1b", result.stderr)


class Meshes(Refused):
    """Meshes of other programs. Skipped where octetvdb-gmsh was not built."""

    FOLDER = os.path.join(command.DATA, "gmsh")

    @classmethod
    def setUpClass(cls):
        done = OCTETVDB.run("info", os.path.join(cls.FOLDER, "two_tets.mesh"))
        if "octetvdb-gmsh: is not installed" in done.stderr:
            raise unittest.SkipTest("without octetvdb-gmsh")

    def read(self, name):
        with open(os.path.join(self.FOLDER, name), "rb") as file:
            return file.read()

    def test_cut_off_anywhere(self):
        """Refused; or, where nothing is lost but an ending, read as if whole; or, behind a section of
        a .msh, which is then a whole file, read without the data of the sections that are gone."""
        for name in sorted(os.listdir(self.FOLDER)):
            if not name.endswith((".msh", ".mesh", ".vtk")):
                continue
            content = self.read(name)
            whole = OCTETVDB.run("info", self.write(name, content)).stdout
            step = len(content) // (6 if OCTETVDB.sanitized else 30) + 1
            cuts = [*range(0, len(content), step), len(content) - 2]
            os.makedirs(os.path.join(self.inputs, "cut"), exist_ok=True)
            paths = [os.path.join(self.inputs, "cut", str(n), name) for n in cuts]
            for n, path in zip(cuts, paths):
                os.makedirs(os.path.dirname(path))
                with open(path, "wb") as file:
                    file.write(content[:n])
            results = command.in_parallel(lambda p: OCTETVDB.run("info", p), paths)
            accepted = 0
            for n, path, result in zip(cuts, paths, results):
                if result.returncode == 0:
                    accepted += 1
                    if name.endswith(".msh"):
                        last = content[:n].rstrip().rpartition(b"\n")[2]
                        self.assertTrue(last.startswith(b"$End"), (name, n))
                        self.assertEqual(result.stdout.partition("forms:")[0],
                                         whole.partition("forms:")[0], (name, n))
                    else:
                        self.assertEqual(result.stdout, whole, (name, n))
                        self.assertGreater(n, 0.8 * len(content), name)
                else:
                    self.assertIsNone(command.complaint(result), (name, n))
                    self.assertTrue(result.stderr.startswith(command.PREFIX + path + ": "))
            self.assertLess(accepted, len(cuts) // 2, name)
            shutil.rmtree(os.path.join(self.inputs, "cut"))

    def test_defects(self):
        """One edit each, and what the answer has to tell."""
        msh, old, medit, vtk = (self.read(n).decode() for n in
                                ("two_tets_41.msh", "two_tets_22.msh", "two_tets.mesh",
                                 "two_tets.vtk"))
        tets = medit[medit.index("Tetrahedra"):]
        cases = [
            ("a.msh", "", "is empty"),
            ("a.mesh", "", "is empty"),
            ("a.vtk", "", "is empty"),
            ("a.msh", "SystemCall \"true\";\n", "does not begin with $MeshFormat"),
            ("a.msh", msh.replace("4.1 0 8", "9.9 0 8"), "version 9.9"),
            ("a.msh", old.replace("2.2 0 8", "1.0 0 8"), "version 1.0"),
            ("a.msh", msh.replace("4.1 0 8", "four"), "is no version"),
            ("a.msh", msh[:msh.index("$Nodes")], ""),
            ("a.msh", old[:old.index("$Elements")], "has no tetrahedra"),
            ("a.msh", old.replace("$Elements\n9", "$Elements\n900"), ""),
            ("a.msh", old.replace("$Elements\n9", "$Elements\n8"), "more rows"),
            ("a.msh", old.replace("$Nodes\n6", "$Nodes\n999999999"), ""),
            ("a.msh", old.replace("\n3 1 0 0\n", "\n3 1 nan 0\n"), ""),
            ("a.msh", old.replace("\n3 1 0 0\n", "\n3 0 0 0\n"), "is degenerate"),
            ("a.msh", old.replace("\n20 0 0 1\n", "\n10 0 0 1\n"), "node"),
            ("a.msh", old.replace('"velocity"', '""'), "has no name"),
            ("a.mesh", medit.replace("Dimension\n3", "Dimension\n2"), "the dimension is not 3"),
            ("a.mesh", medit.replace("MeshVersionFormatted 2", "MeshVersionFormatted 7"), "version"),
            ("a.mesh", medit.replace("Tetrahedra\n2", "Tetrahedra\n-2"), "is not the number"),
            ("a.mesh", medit.replace("Tetrahedra\n2", "Tetrahedra\n3"), "Tetrahedra"),
            ("a.mesh", medit.replace(tets, "End\n"), "has no tetrahedra"),
            ("a.mesh", medit.replace(tets, tets.replace("1", "77", 1)), ""),
            ("a.vtk", vtk.replace("# vtk DataFile Version 2.0", "# vtk DataFile Version 5.1"),
             "up to version 4.2"),
            ("a.vtk", vtk.replace("UNSTRUCTURED_GRID", "POLYDATA"), "UNSTRUCTURED_GRID"),
            ("a.vtk", vtk.replace("ASCII", "TEXT"), "is neither ASCII nor BINARY"),
            ("a.vtk", vtk.rstrip(), "cut off"),
        ]
        for number, (name, content, reason) in enumerate(cases):
            os.mkdir(os.path.join(self.inputs, str(number)))
            path = self.write(os.path.join(str(number), name), content.encode())
            # Not a good file: the edit did take place.
            self.assertNotIn(content, (msh, old, medit, vtk), number)
            for said in self.check_all([path], every_command=False).values():
                self.assertIn(reason, said, (number, name))

    def test_other_cells(self):
        for code, name in ((12, "hexahedra"), (14, "pyramids")):
            n = 8 if code == 12 else 5
            points = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)][:n]
            order = {12: (0, 1, 3, 2, 4, 5, 7, 6), 14: (0, 1, 3, 2, 4)}[code]
            text = ("# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                    f"POINTS {n} double\n" + "".join("%d %d %d\n" % p for p in points) +
                    f"CELLS 1 {n + 1}\n{n} " + " ".join(map(str, order)) +
                    f"\nCELL_TYPES 1\n{code}\n")
            said = self.check_all([self.write("cells.vtk", text.encode())], every_command=False)
            self.assertIn("1 " + name, list(said.values())[0])


class Vdbs(Refused):
    """`info` of files that are no .vdb."""

    def test_info_of_a_damaged_vdb(self):
        whole = os.path.join(self.inputs, "whole.vdb")
        asset = os.path.join(command.DATA, "wellformed", "good.octet.json")
        self.assertEqual(OCTETVDB.run("bake", asset, "-o", whole, "--resolution", "6",
                                      "--form", "mass").returncode, 0)
        with open(whole, "rb") as file:
            content = file.read()
        step = max(1, len(content) // (10 if OCTETVDB.sanitized else 40))
        paths = [self.write(f"cut{n}.vdb", content[:n]) for n in range(0, len(content), step)]
        paths.append(self.write("text.vdb", b"not a grid\n" * 100))
        for path, result in zip(paths, command.in_parallel(lambda p: OCTETVDB.run("info", p), paths)):
            self.assertIsNone(command.complaint(result), path)
            self.assertIn("is not a readable .vdb", result.stderr)


def feed(path, start, piece):
    """Writes a gigabyte into a pipe, or as much as the reader wants."""
    block = piece * ((1 << 20) // len(piece))
    try:
        with open(path, "wb", buffering=0) as pipe:
            pipe.write(start)
            for _ in range(GIGABYTE // len(block) + 1):
                pipe.write(block)
    except BrokenPipeError:
        pass


def write_answers():
    with open(ANSWERS, "w") as file:
        file.write("# What octetvdb answers to each file: place and reason. Written by "
                   "malformed_test.py --write-answers, read by a person.\n")
        for name in corpus():
            path = os.path.join(CORPUS, name)
            result = OCTETVDB.run("info", path)
            assert not command.complaint(result), (name, result)
            file.write(f"{name}: {answer(result.stderr, path)}\n")


if __name__ == "__main__":
    if "--write-answers" in sys.argv:
        write_answers()
    else:
        unittest.main()
