# SPDX-License-Identifier: Apache-2.0
"""What the sample scripts share: simple cages, integrals of fields over their simplices, and the
control asset as a file. Python's standard library only."""
import itertools
import json
import math


class Cage:
    """A control mesh: vertices, tetrahedra and octahedra, with its edges and facets ascending."""

    def __init__(self, vertices, tetrahedra=(), octahedra=(), creases=None, corners=()):
        self.vertices = [tuple(map(float, v)) for v in vertices]
        self.tetrahedra = [tuple(t) for t in tetrahedra]
        self.octahedra = [tuple(o) for o in octahedra]
        self.creases, self.corners = creases, list(corners)
        facets = [f for t in self.tetrahedra for f in itertools.combinations(sorted(t), 3)]
        for o in self.octahedra:
            axes = ((o[0], o[5]), (o[1], o[3]), (o[2], o[4]))
            facets += [tuple(sorted(f)) for f in itertools.product(*axes)]
        count = {}
        for f in facets:
            count[f] = count.get(f, 0) + 1
        self.facets = sorted(count)
        self.boundary_facets = {f for f, n in count.items() if n == 1}
        self.edges = sorted({e for f in self.facets for e in itertools.combinations(f, 2)})
        self.boundary_edges = {e for f in self.boundary_facets
                               for e in itertools.combinations(f, 2)}

    def circulation(self, field, edge):
        """Integral of a vector field along an edge, by Gauss quadrature of order 9."""
        a, b = (self.vertices[v] for v in edge)
        along = _minus(b, a)
        return sum(w * _dot(field(_mix((a, 1 - t), (b, t))), along) for t, w in _GAUSS)

    def curl_flux(self, field, facet):
        """Flux of the curl of `field` through a facet: its circulation around it."""
        a, b, c = facet
        return (self.circulation(field, (a, b)) + self.circulation(field, (b, c))
                - self.circulation(field, (a, c)))

    def flux(self, field, facet):
        """Flux of a vector field through a facet, in the direction of its stored order."""
        a, b, c = (self.vertices[v] for v in facet)
        area = _cross(_minus(b, a), _minus(c, a))
        total = 0.0
        for s, ws in _GAUSS:
            for t, wt in _GAUSS:
                point = _mix((a, 1 - s), (b, s * (1 - t)), (c, s * t))
                total += ws * wt * s * _dot(field(point), area)
        return total


def form(name, degree, unit, coefficients):
    """A form from {simplex: value}, or from {simplex: {frame: value}} when it is animated."""
    kept = {s: v for s, v in coefficients.items() if v != 0}
    result = {"name": name, "degree": degree, "unit": unit, "simplices": [list(s) for s in kept]}
    animated = any(isinstance(v, dict) for v in kept.values())
    if not animated:
        result["values"] = list(kept.values())
        return result
    frames = sorted({f for v in kept.values() for f in v})
    result["frames"] = {str(f): [v[f] for v in kept.values()] for f in frames}
    return result


def write(path, name, cage, forms, **units):
    """Writes the control asset, one line a member."""
    document = {"octet": 1, "name": name, "up_axis": "Z", "meters_per_unit": 1.0,
                "frames_per_second": 24, **units}
    document["vertices"] = [list(v) for v in cage.vertices]
    document["tetrahedra"] = [list(t) for t in cage.tetrahedra]
    document["octahedra"] = [list(o) for o in cage.octahedra]
    if cage.creases is not None:
        document["creases"] = [list(c) for c in cage.creases]
    if cage.corners:
        document["corners"] = cage.corners
    document["forms"] = forms
    with open(path, "w") as file:
        file.write("{\n" + ",\n".join(f"{json.dumps(k)}: {json.dumps(v)}"
                                      for k, v in document.items()) + "\n}\n")


def box(cells, size):
    """A box of cubes, six tetrahedra each. Its edges are creases by default, since they are sharp."""
    n = cells
    index = {p: k for k, p in enumerate(itertools.product(*(range(m + 1) for m in n)))}
    vertices = [tuple(size[k] * (p[k] / n[k] - 0.5) for k in range(3)) for p in index]
    tetrahedra = []
    for corner in itertools.product(*(range(m) for m in n)):
        for axes in itertools.permutations(range(3)):
            at, path = list(corner), [corner]
            for axis in axes:
                at[axis] += 1
                path.append(tuple(at))
            tetrahedra.append([index[p] for p in path])
    return Cage(vertices, tetrahedra)


OCTAHEDRON = ((0, 0, 1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, -1))


def lattice(inside, radius, creases=None):
    """Cells of the face-centred cubic lattice all of whose vertices satisfy `inside`."""
    index = {}

    def number(p):
        return index.setdefault(p, len(index))

    tetrahedra, octahedra = [], []
    reach = range(-radius - 1, radius + 2)
    for p in itertools.product(reach, repeat=3):
        cube = [tuple(map(sum, zip(p, q))) for q in itertools.product((0, 1), repeat=3)]
        even = [q for q in cube if sum(q) % 2 == 0]
        if all(inside(q) for q in even):
            tetrahedra.append([number(q) for q in even])
        around = [tuple(map(sum, zip(p, q))) for q in OCTAHEDRON]
        if sum(p) % 2 and all(inside(q) for q in around):
            octahedra.append([number(q) for q in around])
    return Cage(list(index), tetrahedra, octahedra, creases)


def _minus(a, b):
    return tuple(x - y for x, y in zip(a, b))


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _mix(*terms):
    return tuple(sum(w * p[k] for p, w in terms) for k in range(3))


def _gauss5():
    """Nodes and weights of five-point Gauss-Legendre quadrature on [0, 1]."""
    rule = [(0.0, 128 / 225)]
    for sign in (-1, 1):
        root = 2 * math.sqrt(10 / 7) * sign
        rule.append((math.sqrt(5 + root) / 3, (322 - sign * 13 * math.sqrt(70)) / 900))
        rule.append((-math.sqrt(5 + root) / 3, (322 - sign * 13 * math.sqrt(70)) / 900))
    return [((1 + x) / 2, w / 2) for x, w in rule]


_GAUSS = _gauss5()
