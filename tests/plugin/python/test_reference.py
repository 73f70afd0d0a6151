# SPDX-License-Identifier: Apache-2.0
"""plugin/python/README.md is what the docstrings and stubs say, and its examples run. With --write it is
made so: PYTHONPATH=build/release/plugin/python python3 tests/plugin/python/test_reference.py --write"""
import os
import re
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../..")
PAGE = os.path.join(ROOT, "plugin/python/README.md")
MARK = "<!-- Below: make_reference.py, from docstrings and stubs. -->\n"
sys.path.insert(0, os.path.join(ROOT, "plugin/python/tools"))
import make_reference


def read():
    with open(PAGE) as file:
        return file.read().partition(MARK)


def test_the_page_is_what_the_module_says():
    _, mark, below = read()
    assert mark and below.strip() == make_reference.reference().strip(), \
        "out of date: see the head of this file"


def test_every_name_is_described():
    import octetvdb
    _, _, below = read()
    described = set(re.findall(r"^### (\w+)$", below, re.M))
    assert described == set(octetvdb.__all__) - {"__version__"}


def test_its_example_runs(tmp_path):
    above, _, _ = read()
    blocks = re.findall(r"```python\n(.*?)```", above, re.S)
    assert blocks
    os.symlink(os.path.abspath(os.path.join(ROOT, "samples")), tmp_path / "samples")
    for block in blocks:
        done = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, capture_output=True,
                              text=True)
        assert done.returncode == 0, done.stderr


if __name__ == "__main__" and "--write" in sys.argv:
    above, _, _ = read()
    with open(PAGE, "w") as file:
        file.write(above.rstrip() + "\n\n" + MARK + "\n" + make_reference.reference())
