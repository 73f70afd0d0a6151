# SPDX-License-Identifier: Apache-2.0
"""Runs the checks of the add-on inside the real Blender, headless, for addon_test.py.

Arguments after "--": the add-on's zip, a folder for files. Prints "PASSED name" for each check;
ONLY=part in the environment takes those with the part in their names.
"""
import importlib
import os
import sys
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))


def all_checks():
    for room in ("cages", "flows", "previews", "bakes", "whole"):
        module = importlib.import_module("checks." + room)
        for name, check in vars(module).items():
            if name.startswith("check_"):
                yield name, check


def main():
    failed = []
    only = os.environ.get("ONLY", "")
    for name, check in all_checks():
        if only not in name:
            continue
        before = time.perf_counter()
        try:
            check()
            print(f"PASSED {name[6:]} {time.perf_counter() - before:.1f} s")
        except Exception:  # noqa: B902 - the other checks still run
            failed.append(name)
            print(f"FAILED {name[6:]}\n{traceback.format_exc()}")
        sys.stdout.flush()
    sys.exit(1 if failed else 0)


main()
