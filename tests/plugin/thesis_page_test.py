#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The page of the thesis' figures is made by one command, with every picture and a measured number
for every caption. Arguments: the octetvdb command.
"""
import os
import re
import subprocess
import sys
import tempfile
import unittest

OCTETVDB = os.path.abspath(sys.argv.pop(1))
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)),
                      "../../samples/thesis/figures.py")
FIGURES = ["2.11", "2.14", "3.5", "3.6", "4.14", "4.15", "4.16", "4.17", "4.18", "4.19", "4.20",
           "X2", "5.3", "5.4", "5.6", "5.7", "5.14", "5.15", "5.17", "5.19", "5.20", "boundary"]


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        subprocess.run([sys.executable, SCRIPT, OCTETVDB, "-o", cls.folder.name, "--quick"],
                       check=True, capture_output=True)
        with open(os.path.join(cls.folder.name, "index.html")) as file:
            cls.page = file.read()

    def test_every_figure_has_a_claim_and_a_finding(self):
        sections = dict(re.findall(r'<h2 id="([^"]+)">(.*?)(?=<h2 |\Z)', self.page, re.S))
        self.assertEqual(list(sections), FIGURES)
        for number, section in sections.items():
            self.assertIn("<b>Caption, in short:</b>", section, number)
            findings = re.findall(r'<p class="(?:holds|does not hold|note)"><b>[^<]*</b>(.*?)</p>',
                                  section)
            self.assertTrue(findings, number)
            for finding in findings:
                self.assertRegex(finding, r"[0-9]", number)

    def test_guesses_are_told(self):
        told = re.findall(r'<h2 id="([^"]+)">(?:(?!<h2 ).)*?<p class="guess">', self.page, re.S)
        self.assertLessEqual({"4.15", "4.19", "5.6", "5.7", "5.17"}, set(told))
        for number in told:
            self.assertIn(f'<a href="#{number}">', self.page[:self.page.index("<h2 ")])

    def test_every_picture_is_there(self):
        pictures = re.findall(r'<img src="([^"]+)"', self.page)
        self.assertGreater(len(pictures), 40)
        for picture in pictures:
            with open(os.path.join(self.folder.name, picture), "rb") as file:
                self.assertEqual(file.read(8), b"\x89PNG\r\n\x1a\n", picture)

    def test_what_holds_and_what_does_not_is_said(self):
        """Fluxes on extraordinary edges: see analysis_test, which has their growth."""
        section = self.page[self.page.index('id="X2"'):].split("<h2", 1)[0]
        self.assertIn("<b>holds:</b> 2-forms, 3 to 12", section)
        self.assertNotIn("<b>does not hold:</b>", section)
        section = self.page[self.page.index('id="5.15"'):].split("<h2", 1)[0]
        self.assertIn("<b>does not hold:</b>", section)


if __name__ == "__main__":
    unittest.main()
