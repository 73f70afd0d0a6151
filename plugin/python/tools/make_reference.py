#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Prints the reference of the Python module in Markdown: signatures from the stubs, words from the
docstrings. Needs the built module: PYTHONPATH=build/release/plugin/python

`tests/plugin/python/test_reference.py --write` puts it into README.md, below the mark.
"""
import ast
import inspect
import os

import octetvdb

STUBS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "octetvdb",
                     "_octetvdb.pyi")
# Groups of the reference, in order; what is in none comes last.
GROUPS = {
    "Assets": ["ControlAsset", "ControlMesh", "Form", "Complex", "from_meshio", "to_meshio"],
    "Cages": ["box_cage", "fill_surface", "fill_tetrahedra", "cage_quality", "CageQuality"],
    "Flows": ["integrate", "UniformFlow", "RigidRotation", "VortexLine", "VortexRing", "PointSource",
              "CurlNoise", "nearest_closed", "Fit", "FitResult", "FitReport", "GuideCurve",
              "GuideVector", "GuideReport", "GuideConflict", "sample_velocity", "SampledFrame"],
    "Fields": ["Refiner", "Field", "streamlines", "spaced_points"],
    "Grids": ["bake", "BakeReport", "BakedFile", "merge", "GridInfo", "targets", "read_grid_info",
              "verify",
              "VerifiedGrid", "Certificate"],
    "Else": [],
}


def stub_signatures():
    """Signatures in the stubs: name -> text, and class -> {member -> text}."""
    functions, classes = {}, {}
    with open(STUBS) as file:
        tree = ast.parse(file.read())
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            functions[node.name] = signature(node)
        if isinstance(node, ast.ClassDef):
            classes[node.name] = {member.name: signature(member) for member in node.body
                                  if isinstance(member, ast.FunctionDef)}
    return functions, classes


def signature(node):
    """"(a: int, *, b: str = ...) -> float", without self."""
    arguments = ast.parse(f"def f({ast.unparse(node.args)}): ...").body[0].args
    if arguments.args and arguments.args[0].arg == "self":
        arguments.args = arguments.args[1:]
    result = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"({ast.unparse(arguments)}){result}"


def words(thing):
    """A docstring without the signatures that pybind11 puts before it."""
    text = inspect.cleandoc(thing.__doc__ or "")
    lines = text.splitlines()
    while lines and ("->" in lines[0] and "(" in lines[0] or not lines[0].strip()):
        lines.pop(0)
    return "\n".join(lines).strip()


def broken(call):
    """A call on lines of its own for each argument, where it is long."""
    if len(call) <= 100:
        return call
    tree = ast.parse(f"def {call}: ...").body[0]
    text = ast.unparse(tree.args)
    parts, depth, part = [], 0, ""
    for c in text:
        depth += (c in "[(") - (c in "])")
        if c == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += c
    inner = "".join(f"    {p},\n" for p in [*parts, part.strip()])
    result = f" -> {ast.unparse(tree.returns)}" if tree.returns else ""
    return f"{tree.name}(\n{inner}){result}"


def described(name, text, sign=""):
    out = f"### {name}\n\n"
    if sign:
        out += f"```python\n{broken(name + sign)}\n```\n\n"
    # As it stands: columns of parameters keep their places.
    return out + f"```text\n{text}\n```\n\n" if text else out


def class_reference(name, cls, members):
    out = described(name, words(cls), members.get("__init__", "").replace(" -> None", ""))
    rows = []
    for member in vars(cls):
        if member.startswith("_"):
            continue
        sign = members.get(member, "()")
        if isinstance(inspect.getattr_static(cls, member), property):
            sign = sign.replace("() -> ", ": ")
        rows.append((cell(member + sign), cell(words(getattr(cls, member)))))
    if rows:
        out += "| member | what it is |\n|---|---|\n"
        out += "".join(f"| `{left}` | {right} |\n" for left, right in rows) + "\n"
    return out


def cell(text):
    return " ".join(text.split()).replace("|", "\\|")


def reference():
    functions, classes = stub_signatures()
    grouped = {name for names in GROUPS.values() for name in names}
    groups = {**GROUPS, "Else": sorted(n for n in octetvdb.__all__
                                       if n not in grouped and n != "__version__")}
    out = ""
    for group, names in groups.items():
        out += f"## {group}\n\n"
        for name in names:
            value = getattr(octetvdb, name)
            if inspect.isclass(value):
                out += class_reference(name, value, classes.get(name, {}))
            elif callable(value):
                sign = functions.get(name) or str(inspect.signature(value))
                out += described(name, words(value), sign)
            else:
                out += described(name, f"{value!r}")
    return out.rstrip() + "\n"


if __name__ == "__main__":
    print(reference(), end="")
