#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Five ways to subdivide at the boundary, measured on four meshes.

    compare.py OCTETVDB [--levels K] [--json FILE]

Prints a table, or with --json writes its numbers. For every mesh and method, after K levels:
  constants      largest error of a constant field's circulations and fluxes
  linear         the same of a field that is linear in position
  attenuation    how much of a constant flux is left next to the boundary, its projection on itself
  bending        mean angle between a turning flow and what it became there, degrees
  volume         of the refined mesh, against the control mesh
  leak           flux through the boundary made from none, by random fluxes inside
  divergence     of a divergence-free flux, in any cell
Errors are relative to the largest exact coefficient; "there" is at boundary vertices.
"""
import argparse
import json
import os
import sys

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import measure

METHODS = ("walls", "open", "simple", "projection", "expansion")
LEVELS = 2
BALL = os.path.join(measure.HERE, "..", "ball", "ball.octet.json")
CONSTANT = np.array([0.4, -0.7, 0.6])
SLOPE = np.array([[-0.4, 0.3, 0.1], [0.2, 0.5, -0.2], [0.3, 0.1, -0.1]])     # no trace


def constant(p):
    return np.broadcast_to(CONSTANT, p.shape)


def linear(p):
    return CONSTANT + p @ SLOPE.T


def turning(p):
    return np.column_stack([0.3 - p[:, 1], p[:, 0] - 0.2 * p[:, 2], 0.5 + 0.2 * p[:, 1]])


def meshes():
    yield "M_E", measure.load("M_E")
    yield "M_X", measure.load("M_X")
    yield "M_B", measure.load("M_B")
    with open(BALL) as file:
        yield "ball", json.load(file)


def sources(run, document):
    """The forms whose refinement is measured."""
    control = run.refine(measure.with_forms(document, {}), 0)
    forms = {}
    for degree, letter in ((1, "e"), (2, "f")):
        for name, field in (("constant", constant), ("linear", linear), ("turning", turning)):
            forms[f"{name}_{letter}"] = (degree, control.simplices(degree),
                                         control.integrals(field, degree))
    random = np.random.default_rng(1).uniform(-1, 1, len(control.facets))
    random[control.facet_on_boundary] = 0
    forms["inside"] = (2, control.facets, random)
    return control, measure.with_forms(document, forms)


def relative_error(fine, name, field):
    most = 0.0
    for degree, letter in ((1, "e"), (2, "f")):
        exact = fine.integrals(field, degree)
        most = max(most, abs(fine.forms[f"{name}_{letter}"] - exact).max() / abs(exact).max())
    return most


def attenuation(fine):
    near = fine.touching(2)
    exact, got = fine.integrals(constant, 2)[near], fine.forms["constant_f"][near]
    return float(got @ exact / (exact @ exact))


def bending(fine):
    vertices = np.flatnonzero(fine.vertex_on_boundary)
    exact = turning(fine.x[vertices])
    angles = []
    for degree, letter in ((1, "e"), (2, "f")):
        got = fine.vertex_vectors(fine.forms[f"turning_{letter}"], degree, vertices)
        size = np.linalg.norm(got, axis=1) * np.linalg.norm(exact, axis=1)
        cosine = np.einsum("ij,ij->i", got, exact) / np.where(size > 0, size, 1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())
    return max(angles)


def measured(run, control, document, method, levels):
    fine = run.refine(document, levels, method)
    inside = fine.forms["inside"]
    exact = fine.integrals(turning, 2)
    return {"constants": relative_error(fine, "constant", constant),
            "linear": relative_error(fine, "linear", linear),
            "attenuation": attenuation(fine),
            "bending": bending(fine),
            "volume": fine.volume() / control.volume(),
            "leak": abs(inside[fine.facet_on_boundary]).max() / abs(inside).max(),
            "divergence": fine.divergence(fine.forms["turning_f"]) / abs(exact).max()}


def compare(run, levels, which=None):
    """{mesh: {method: {quantity: number}}}"""
    result = {}
    for name, document in meshes():
        if which and name not in which:
            continue
        control, document = sources(run, document)
        result[name] = {m: measured(run, control, document, m, levels) for m in METHODS}
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("octetvdb")
    parser.add_argument("--levels", type=int, default=LEVELS)
    parser.add_argument("--mesh", action="append", help="only this one; repeatable")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    table = compare(measure.Octetvdb(arguments.octetvdb), arguments.levels, arguments.mesh)
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump(table, file, indent=1)
    for mesh, rows in table.items():
        quantities = list(next(iter(rows.values())))
        print(f"{mesh:11}" + "".join(f"{q:>13}" for q in quantities))
        for method, numbers in rows.items():
            print(f"  {method:9}" + "".join(f"{numbers[q]:13.3g}" for q in quantities))


if __name__ == "__main__":
    main()
