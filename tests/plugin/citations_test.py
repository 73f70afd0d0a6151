#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What the texts refer to is there: sections of core/SCHEME.md that are cited, headings of other
documents, and the files and headings that links in Markdown lead to. Argument: the repository's folder.
"""
import os
import re
import subprocess
import sys
import unittest

ROOT = os.path.abspath(sys.argv.pop(1))
# "SCHEME.md section 6b", "SCHEME.md sections 3 to 8", "SCHEME.md sections 5 and 9".
SECTION = re.compile(r"SCHEME\.md\W{0,3}sections? (\d+[a-z]?)(?:(?:,| to| and) (\d+[a-z]?))*")
# 'converters/README.md, "Targets"'.
QUOTED = re.compile(r'([\w/]+\.md), "([^"]+)"')
LINK = re.compile(r"\]\(([^)\s]+)\)")
TEXTS = (".h", ".cpp", ".py", ".pyi", ".md", ".txt", ".sh", ".cmake")


def files():
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "--cached", "--others",
                             "--exclude-standard"], capture_output=True, text=True)
    if listed.returncode == 0:
        names = listed.stdout.splitlines()
    else:  # a copy without its history
        names = [os.path.relpath(os.path.join(folder, name), ROOT)
                 for folder, _, found in os.walk(ROOT) for name in found
                 if not os.path.relpath(folder, ROOT).startswith(("build", "."))
                 or folder == ROOT]
    return [n for n in names if n.endswith(TEXTS) and os.path.isfile(os.path.join(ROOT, n))]


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def prose(name):
    """A file on one line, without the marks that comments begin their lines with."""
    return re.sub(r"\s*\n\s*(?:///?<?|#)?\s*", " ", read(name))


def headings(name):
    """The headings of a document, which stand outside its blocks of code."""
    text = re.sub(r"^```.*?^```", "", read(name), flags=re.M | re.S)
    return re.findall(r"^#+ (.+?)\s*$", text, re.M)


def anchor(heading):
    """A heading's name in links, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.replace("`", "").lower()).replace(" ", "-")


class Citations(unittest.TestCase):
    def test_cited_sections_of_the_scheme_exist(self):
        sections = {m[1] for m in (re.match(r"(\d+[a-z]?)\. ", h) for h in headings("core/SCHEME.md"))
                    if m}
        cited = [(name, number) for name in files() for match in SECTION.finditer(prose(name))
                 for number in re.findall(r"\b\d+[a-z]?\b", match[0])]
        self.assertGreater(len(cited), 40, "citations are no longer found")
        self.assertEqual([c for c in cited if c[1] not in sections], [])

    def test_cited_headings_exist(self):
        cited = [(name, document, heading) for name in files()
                 for document, heading in QUOTED.findall(prose(name))
                 if name != "tests/plugin/citations_test.py"]
        self.assertGreater(len(cited), 2, "citations are no longer found")
        for name, document, heading in cited:
            with self.subTest(file=name, document=document):
                self.assertIn(heading, headings(document))

    def test_links_lead_somewhere(self):
        links = [(name, target) for name in files() if name.endswith(".md")
                 for target in LINK.findall(read(name)) if not re.match(r"\w+:", target)]
        self.assertGreater(len(links), 20, "links are no longer found")
        for name, target in links:
            with self.subTest(file=name, link=target):
                path, _, fragment = target.partition("#")
                to = os.path.normpath(os.path.join(os.path.dirname(name), path)) if path else name
                self.assertFalse(to.startswith(".."), "leads out of the repository")
                self.assertTrue(os.path.exists(os.path.join(ROOT, to)))
                if fragment:
                    self.assertIn(fragment, map(anchor, headings(to)))

    def test_texts_named_by_path_exist(self):
        """Paths of documents that comments name, such as samples/conservation/README.md."""
        for name in files():
            for path in re.findall(r"\b(?:core|converters|plugin|tests|samples)/[\w/]*\w+\.md\b",
                                   read(name)):
                with self.subTest(file=name, document=path):
                    self.assertTrue(os.path.exists(os.path.join(ROOT, path)))


unittest.main()
