#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Traces particles through the flow of a control asset, without a grid: the field is sampled where
the particles are.

Usage: trace.py [CONTROL.octet.json [OUT.npy]]; the file gets the paths, float64 (steps, particles, 3)
"""
import os
import sys

import numpy as np

import octetvdb


def trace(field, points, step, count):
    """Paths of particles by the classical Runge-Kutta method, (count + 1, particles, 3)."""
    def velocity(x):
        return field.sample(x)[0]

    paths = [points]
    for _ in range(count):
        x = paths[-1]
        k1 = velocity(x)
        k2 = velocity(x + step / 2 * k1)
        k3 = velocity(x + step / 2 * k2)
        k4 = velocity(x + step * k3)
        paths.append(x + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    return np.array(paths)


def main(control, out=None):
    asset = octetvdb.ControlAsset.read(control)
    form = next(f for f in asset.forms if f.degree == 2)
    field = octetvdb.Refiner(asset.mesh, levels=2).field(2, form.coefficients())
    low, high = field.bounds
    start = np.random.default_rng(1).uniform(low, high, (200, 3))
    start = start[field.sample(start)[1]]
    paths = trace(field, start, 0.04, 250)
    stayed = field.sample(paths[-1])[1]
    length = np.linalg.norm(np.diff(paths, axis=0), axis=2).sum(axis=0)
    print(f"{form.name}: {len(start)} particles, mean path {length.mean():.2f}, "
          f"{stayed.sum()} still inside after {len(paths) - 1} steps")
    if out:
        np.save(out, paths)


if __name__ == "__main__":
    here = os.path.dirname(os.path.abspath(__file__))
    main(*sys.argv[1:] or [os.path.join(here, "../box/box.octet.json")])
