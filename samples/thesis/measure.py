# SPDX-License-Identifier: Apache-2.0
"""What the scripts here share: running octetvdb, and measuring refined coefficients with numpy."""
import itertools
import json
import os
import subprocess
import tempfile

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
OUTWARD_TET = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
OUTWARD_OCT = ((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1),
               (5, 2, 1), (5, 3, 2), (5, 4, 3), (5, 1, 4))
GAUSS = [((1 + x) / 2, w / 2) for x, w in zip(*np.polynomial.legendre.leggauss(4))]


class Octetvdb:
    """The command; everything it writes goes to a folder of its own."""

    def __init__(self, command):
        self.command = os.path.abspath(command)
        self.folder = tempfile.TemporaryDirectory()

    def __call__(self, *arguments):
        done = subprocess.run([self.command, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"octetvdb {' '.join(map(str, arguments))}\n{done.stderr}")
        return done.stdout

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def refine(self, asset, levels, boundary="auto", *options):
        """An asset (a path or a document) refined, as a Mesh."""
        if isinstance(asset, dict):
            path = self.path("asset.octet.json")
            with open(path, "w") as file:
                json.dump(asset, file)
            asset = path
        out = self.path("refined.json")
        self("refine", asset, "--levels", levels, "--boundary", boundary, "-o", out, *options)
        with open(out) as file:
            return Mesh(json.load(file))

    def analyse(self, asset, vertex, *options):
        return json.loads(self("analyse", asset, "--vertex", vertex, "--json", *options))


class Mesh:
    """A refined document as arrays."""

    def __init__(self, document):
        self.x = np.array(document["vertices"], float)
        self.edges = np.array(document["edges"], int).reshape(-1, 2)
        self.facets = np.array(document["facets"], int).reshape(-1, 3)
        self.tets = np.array(document["tetrahedra"], int).reshape(-1, 4)
        self.octs = np.array(document["octahedra"], int).reshape(-1, 6)
        self.forms = {n: np.array(f["values"], float) for n, f in document["forms"].items()}
        corners = [self.tets[:, list(f)] for f in OUTWARD_TET]
        corners += [self.octs[:, list(f)] for f in OUTWARD_OCT]
        used = np.sort(np.concatenate(corners), axis=1)
        unique, counts = np.unique(used, axis=0, return_counts=True)
        order = np.lexsort(np.sort(self.facets, axis=1).T[::-1])
        self.facet_on_boundary = np.zeros(len(self.facets), bool)
        self.facet_on_boundary[order] = counts == 1     # both are in lexicographic order
        self.vertex_on_boundary = np.zeros(len(self.x), bool)
        self.vertex_on_boundary[self.facets[self.facet_on_boundary].ravel()] = True
        edges = {tuple(sorted(e)) for f in self.facets[self.facet_on_boundary]
                 for e in itertools.combinations(f, 2)}
        self.edge_on_boundary = np.array([tuple(sorted(e)) in edges for e in self.edges])

    def vectors_of_simplices(self, degree):
        """Edge vectors or area vectors."""
        if degree == 1:
            return self.x[self.edges[:, 1]] - self.x[self.edges[:, 0]]
        a, b, c = (self.x[self.facets[:, k]] for k in range(3))
        return np.cross(b - a, c - a) / 2

    def simplices(self, degree):
        return self.edges if degree == 1 else self.facets

    def touching(self, degree):
        """Simplices with a vertex on the boundary."""
        return self.vertex_on_boundary[self.simplices(degree)].any(axis=1)

    def integrals(self, field, degree):
        """Circulations or fluxes of a vector field, points in rows."""
        v = self.vectors_of_simplices(degree)
        total = np.zeros(len(v))
        corners = [self.x[self.simplices(degree)[:, k]] for k in range(degree + 1)]
        if degree == 1:
            for t, w in GAUSS:
                p = (1 - t) * corners[0] + t * corners[1]
                total += w * np.einsum("ij,ij->i", field(p), v)
            return total
        for (s, ws), (t, wt) in itertools.product(GAUSS, GAUSS):
            p = (1 - s) * corners[0] + s * (1 - t) * corners[1] + s * t * corners[2]
            total += 2 * ws * wt * s * np.einsum("ij,ij->i", field(p), v)
        return total

    def volume(self):
        total = 0.0
        for cells, outward in ((self.tets, OUTWARD_TET), (self.octs, OUTWARD_OCT)):
            if not len(cells):
                continue
            centre = self.x[cells].mean(axis=1)
            signed = np.zeros(len(cells))
            for f in outward:
                a, b, c = (self.x[cells[:, k]] - centre for k in f)
                signed += np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
            total += abs(signed).sum()
        return total

    def divergence(self, flux):
        """Largest |sum of outward fluxes| of a cell, orientation of cells by their geometry."""
        key = {tuple(sorted(f)): k for k, f in enumerate(map(tuple, self.facets))}
        most = 0.0
        for cells, outward in ((self.tets, OUTWARD_TET), (self.octs, OUTWARD_OCT)):
            for cell in cells:
                total = 0.0
                for f in outward:
                    corner = [cell[k] for k in f]
                    k = key[tuple(sorted(corner))]
                    total += flux[k] * _parity(list(self.facets[k]), corner)
                most = max(most, abs(total))
        return most

    def vertex_vectors(self, form, degree, vertices):
        """Least-squares vectors of the coefficients at vertices; NaN where they do not tell."""
        v, s = self.vectors_of_simplices(degree), self.simplices(degree)
        n = len(self.x)
        square, right = np.zeros((n, 3, 3)), np.zeros((n, 3))
        for k in range(degree + 1):
            np.add.at(square, s[:, k], v[:, :, None] * v[:, None, :])
            np.add.at(right, s[:, k], v * form[:, None])
        return np.array([np.linalg.lstsq(square[i], right[i], rcond=1e-9)[0] for i in vertices])


def _parity(a, b):
    """+1 when two orders of three vertices are even to each other."""
    place = [a.index(x) for x in b]
    return 1 if place in ([0, 1, 2], [1, 2, 0], [2, 0, 1]) else -1


def load(name):
    with open(os.path.join(HERE, name + ".octet.json")) as file:
        return json.load(file)


def with_forms(document, forms):
    """A document with other forms: name -> (degree, simplices, values)."""
    result = {k: v for k, v in document.items() if k != "forms"}
    result["forms"] = [{"name": n, "degree": d, "simplices": np.asarray(s).tolist(),
                        "values": np.asarray(v, float).tolist()}
                       for n, (d, s, v) in forms.items()]
    return result
