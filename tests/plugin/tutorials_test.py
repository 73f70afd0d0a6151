#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tutorials of samples/tutorials print what their page says. Arguments: the programs."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

PROGRAMS = {os.path.basename(p).removeprefix("tutorial_"): os.path.abspath(p) for p in sys.argv[1:]}
del sys.argv[1:]
SAMPLES = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../samples"))


class Tutorials(unittest.TestCase):
    def test_they_print_what_the_page_says(self):
        with open(os.path.join(SAMPLES, "tutorials", "README.md")) as file:
            page = file.read()
        sources = {n.removesuffix(".cpp") for n in os.listdir(os.path.join(SAMPLES, "tutorials"))
                   if n.endswith(".cpp")}
        self.assertEqual(set(PROGRAMS), sources)
        self.assertEqual(len(sources), 5)
        for name, program in sorted(PROGRAMS.items()):
            with self.subTest(tutorial=name), tempfile.TemporaryDirectory() as folder:
                section, = re.findall(rf"\[{name}\.cpp\].*?```text\n(.*?)```", page, re.S)
                outputs = {"4_bake": ["out.vdb"], "5_fit": ["out.octet.json"]}.get(name, [])
                asset = [] if name.startswith("1_") else [f"{SAMPLES}/box/box.octet.json"]
                done = subprocess.run([program, *asset, *outputs], cwd=folder, capture_output=True,
                                      text=True)
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertEqual(done.stdout, section)
                self.assertEqual(sorted(os.listdir(folder)), outputs)


if __name__ == "__main__":
    unittest.main()
