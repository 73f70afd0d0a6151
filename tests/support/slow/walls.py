# SPDX-License-Identifier: Apache-2.0
"""The smooth wall rule of SCHEME.md section 8b once more: slow, by names and sets instead of
numbering, to check the library against. numpy only.

A fine vertex is named by what it comes from: ("v", i) stays, ("e", frozenset of two) is a midpoint,
("o", cell) a centre. moves(claims(mesh)) gives {fine vertex: {coarse vertex: weight}}: by how much each fine
vertex moves when the wall is smooth instead of Loop's, sum of weight times position.
"""
import itertools
import math

import numpy as np

OPPOSITE = (5, 3, 4, 1, 2, 0)
OUTWARD_TRIPLES = ((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 1), (5, 2, 1), (5, 3, 2), (5, 4, 3),
                   (5, 1, 4))


class Mesh:
    def __init__(self, tets, octs, creases=(), corners=()):
        self.cells = [tuple(c) for c in tets] + [tuple(c) for c in octs]
        self.first_oct = len(tets)
        self.creases = {frozenset(e) for e in creases}
        self.corners = set(corners)
        self.star = {}
        facets = {}
        for k, cell in enumerate(self.cells):
            for v in cell:
                self.star.setdefault(v, []).append(k)
            for f in facets_of(cell):
                facets.setdefault(f, []).append(k)
        self.wall = [f for f, cells in facets.items() if len(cells) == 1]
        self.wall_at = {}
        for f in self.wall:
            for v in f:
                self.wall_at.setdefault(v, []).append(f)

    def adjacent(self, cell, a, b):
        """Do a and b share an edge of the cell?"""
        c = self.cells[cell]
        return a in c and b in c and not (len(c) == 6 and across(c, a) == b)


def across(cell, v):
    return cell[OPPOSITE[cell.index(v)]]


def facets_of(cell):
    if len(cell) == 4:
        return [frozenset(t) for t in itertools.combinations(cell, 3)]
    return [frozenset(cell[i] for i in t) for t in OUTWARD_TRIPLES]


def ring_of(mesh, v):
    """The wall vertices around v in order, or None where the wall is not one disk there."""
    links = {}
    for f in mesh.wall_at[v]:
        a, b = f - {v}
        links.setdefault(a, []).append(b)
        links.setdefault(b, []).append(a)
    if any(len(x) != 2 for x in links.values()):
        return None
    ring = [min(links)]
    ring.append(links[ring[0]][0])
    while True:
        following = next(x for x in links[ring[-1]] if x != ring[-2])
        if following == ring[0]:
            break
        ring.append(following)
    return ring if len(ring) == len(links) else None


def midpoint(a, b):
    return {a: .5, b: .5}


def fine_cells(cell, centre):
    """Children of a cell, each a list of (name, weights over the cell's corners)."""
    def corner(v):
        return ("v", v), {v: 1.}

    def mid(a, b):
        return ("e", frozenset((a, b))), midpoint(a, b)
    if len(cell) == 4:
        for v in cell:
            yield [corner(v)] + [mid(v, w) for w in cell if w != v]
        a, b, c, d = cell
        yield [mid(a, b), mid(a, c), mid(a, d), mid(b, d), mid(b, c), mid(c, d)]
        return
    middle = (("o", centre), {v: 1 / 6 for v in cell})
    for i, v in enumerate(cell):
        child = []
        for j, w in enumerate(cell):
            child.append(corner(v) if j == i else middle if j == OPPOSITE[i] else mid(v, w))
        yield child
    for t in OUTWARD_TRIPLES:
        x, y, z = (cell[i] for i in t)
        yield [mid(x, y), mid(y, z), mid(x, z), middle]


def smoothed(mesh, cells, name):
    """Row of S0: the mean over the fine cells at a fine vertex of the per-cell stencils."""
    rows = []
    for k in cells:
        for child in fine_cells(mesh.cells[k], k):
            names = [n for n, _ in child]
            if name not in names:
                continue
            i = names.index(name)
            row = {}
            for j, (_, weights) in enumerate(child):
                if len(child) == 4:
                    w = -1 / 16 if j == i else 17 / 48
                else:
                    w = 3 / 8 if j == i else 7 / 24 if j == OPPOSITE[i] else 1 / 12
                for v, x in weights.items():
                    row[v] = row.get(v, 0) + w * x
            rows.append(row)
    total = {}
    for row in rows:
        for v, x in row.items():
            total[v] = total.get(v, 0) + x / len(rows)
    return total


def loop_beta(n):
    return (5 / 8 - (3 / 8 + math.cos(2 * math.pi / n) / 4) ** 2) / n


def ring_weights(n):
    w = np.zeros(n)
    for k in range(1, n // 2 + 1):
        value = 3 / 8 + math.cos(2 * math.pi * k / n) / 4
        wanted = .5 if k == 1 else .25 if k == 2 else min(value, .2)
        w += (1 if 2 * k == n else 2) / n * (wanted - value) * np.cos(
            2 * np.pi * k / n * np.arange(n))
    return w


def edge_rule(k):
    """Item 2: {row: {column: weight}}; names ("r", side, j), ("o", j), ("a", side), "m"."""
    rows = [("r", s, j) for s in (0, 1) for j in range(1, k)] + [("o", j) for j in range(k)]
    inside, first, wave = np.zeros((len(rows), len(rows))), None, None
    for index in range(1, k + 1):
        theta = math.pi * index / k
        s = math.sqrt(max(0, (1 + math.cos(theta)) / 2))
        p = 3 / 8 + 5 * math.cos(theta) / 24
        if index == k:
            value, alpha, beta, norm = 1 / 6, 1, 1, k
        else:
            value = (p + 1 / 6) / 2 + math.sqrt(((p - 1 / 6) / 2) ** 2 + s * s / 36)
            alpha, beta = s / 24 / (value - 1 / 6), 2 / 3 * s / (value - 1 / 6)
            norm = k * (1 + alpha * beta) / 2
        on_ring = 0 if index == k else 1
        x = np.array([on_ring * math.sin(theta * r[2]) if r[0] == "r"
                      else beta * math.sin(theta * (r[1] + .5)) for r in rows])
        y = np.array([on_ring * math.sin(theta * r[2]) / 2 if r[0] == "r"
                      else alpha * math.sin(theta * (r[1] + .5)) for r in rows])
        wanted = .5 if index == 1 else min(value, 3 / 8)
        inside += (wanted - value) / norm * np.outer(x, y)
        if index == 1:
            first = value
            wave = np.array([math.cos(theta * r[2]) if r[0] == "r"
                             else beta * math.cos(theta * (r[1] + .5)) for r in rows])
    if k == 1:
        wave[:] = 0
    flat = -inside.sum(1) / 7
    shear = ((.5 - first) * wave - inside @ wave) / 4
    result = {}
    for i, row in enumerate(rows):
        to = {c: inside[i, j] for j, c in enumerate(rows)}
        for name in ("m", ("a", 0), ("a", 1)):
            to[name] = flat[i]
        for side in (0, 1):
            to["r", side, 0] = flat[i] + shear[i]
            to["r", side, k] = flat[i] - shear[i]
        result[row] = to
    return result


def half_turn(mesh, cells, m, along, start):
    """Vertices around the edge (m, along), tetrahedra only, from the wall to the wall."""
    left, path = [k for k in cells if mesh.adjacent(k, m, along)], [start]
    if any(len(mesh.cells[k]) == 6 for k in left):
        return None
    while left:
        k = next((k for k in left if path[-1] in mesh.cells[k]), None)
        if k is None:
            return None
        left.remove(k)
        path.append(next(v for v in mesh.cells[k] if v not in (m, along, path[-1])))
    return path


def line_rule(mesh, cells, m, ring, at):
    r = [ring[(at + i) % 6] for i in range(6)]
    up = half_turn(mesh, cells, m, r[0], r[1])
    down = half_turn(mesh, cells, m, r[3], r[2])
    if up is None or down is None or len(up) != len(down):
        return None
    k = len(up) - 1
    named = {"m": m, ("a", 0): r[0], ("a", 1): r[3]}
    for j in range(k + 1):
        named["r", 0, j], named["r", 1, j] = up[j], down[j]
    for j in range(k):
        four = {up[j], up[j + 1], down[j], down[j + 1]}
        found = [c for c in cells if len(mesh.cells[c]) == 6 and four <= set(mesh.cells[c])]
        if len(found) != 1:
            return None
        named["o", j] = across(mesh.cells[found[0]], m)
    return {named[row]: {named[c]: w for c, w in to.items()} for row, to in edge_rule(k).items()}


def subspace(matrix, cut):
    values, vectors = np.linalg.eig(matrix)
    keep = abs(values) > cut
    return values[keep], vectors[:, keep]


def assignment(S, inside, wall, leading):
    """Item 3: rows of moves of the inside, or None."""
    block, cap = S[np.ix_(inside, inside)], .3
    sizes = np.sort(abs(np.linalg.eigvals(block)))[::-1]
    count = int((sizes[1:] > cap + 1e-9).sum()) + bool(leading or sizes[0] > cap + 1e-9)
    if count == 0 or leading and count == 1 and abs(sizes[0] - .5) < 1e-9:
        return None
    while count < len(sizes) and sizes[count - 1] - sizes[count] < 1e-7:
        count += 1
    cut = (sizes[count - 1] + sizes[count]) / 2 if count < len(sizes) else 0
    _, X = subspace(block, cut)
    values, Y = subspace(block.T, cut)
    if X.shape != Y.shape:
        return None
    first = np.argmax(abs(values))
    wanted = np.array([.5 if leading and i == first else v * min(1, cap / abs(v))
                       for i, v in enumerate(values)])
    own = (X @ np.linalg.solve(Y.T @ X, np.diag(wanted - values) @ Y.T)).real
    D = np.zeros_like(S)
    D[np.ix_(inside, inside)] = own
    on_wall, across_wall = S[np.ix_(wall, wall)], S[np.ix_(inside, wall)]
    normal = np.zeros_like(own)
    if leading:
        def mode(A):
            values, vectors = np.linalg.eig(A)
            return vectors[:, np.argmin(abs(values - .5))].real
        x, y = mode(block + own), mode((block + own).T)
        normal = np.outer(x, y) / (y @ x)
    modes, images = [np.ones(len(wall))], [-own.sum(1)]
    values, vectors = np.linalg.eig(on_wall)
    for i, value in enumerate(values):
        if abs(value) <= .35 or abs(value - 1) <= 1e-9:
            continue
        for z in (vectors[:, i].real, vectors[:, i].imag):
            if np.linalg.norm(z) > 1e-9:
                modes.append(z)
                images.append(-normal @ across_wall @ z)
    D[np.ix_(inside, wall)] = np.array(images).T @ np.linalg.pinv(np.array(modes).T, rcond=1e-8)
    if abs(D.sum(1)).max() > 1e-7 or abs(D).max() > 3 or not np.isfinite(D).all():
        return None
    return D


def star_moves(mesh, m):
    """{star vertex: {star vertex: weight}} around wall vertex m, rows of the children in their
    places; and the ring."""
    ring = ring_of(mesh, m)
    if ring is None:
        return {}, []
    n, cells = len(ring), mesh.star[m]
    vertices = sorted({v for k in cells for v in mesh.cells[k]})
    creases = [frozenset((m, r)) in mesh.creases for r in ring]
    corner = m in mesh.corners or sum(creases) not in (0, 2)
    smooth = not corner and not any(creases)
    if not smooth:
        return {}, ring
    index = {v: i for i, v in enumerate(vertices)}
    S, D = np.zeros((len(vertices),) * 2), np.zeros((len(vertices),) * 2)
    for v in vertices:
        if v == m or v in ring:
            continue
        near = [k for k in cells if mesh.adjacent(k, m, v)]
        if near:
            row = smoothed(mesh, near, ("e", frozenset((m, v))))
        else:
            k = next(k for k in cells if v in mesh.cells[k])
            row = smoothed(mesh, [k], ("o", k))
        for w, x in row.items():
            S[index[v], index[w]] = x
    for i, r in enumerate(ring):
        a = index[r]
        if creases[i]:
            S[a, a] = S[a, index[m]] = .5
        else:
            S[a, a] = S[a, index[m]] = 3 / 8
            S[a, index[ring[i - 1]]] += 1 / 8
            S[a, index[ring[(i + 1) % n]]] += 1 / 8
    if corner:
        S[index[m], index[m]] = 1
    elif smooth:
        S[index[m], index[m]] = 1 - n * loop_beta(n)
        for r in ring:
            S[index[m], index[r]] = loop_beta(n)
    else:
        S[index[m], index[m]] = 3 / 4
        for i, r in enumerate(ring):
            if creases[i]:
                S[index[m], index[r]] = 1 / 8
    if smooth and n != 6:
        change, weights = 3 / 8 / n - loop_beta(n), ring_weights(n)
        D[index[m], index[m]] -= n * change
        for i, r in enumerate(ring):
            D[index[m], index[r]] += change
            for j, q in enumerate(ring):
                D[index[r], index[q]] += weights[(j - i) % n]
    inside = [index[v] for v in vertices if v != m and v not in ring]
    wall = [index[v] for v in vertices if v == m or v in ring]
    if inside:
        extra = None
        kinds = [sorted(len(mesh.cells[k]) for k in cells if mesh.adjacent(k, m, r)) for r in ring]
        bad = [i for i in range(n) if kinds[i] != [4, 6]]
        sizes = sorted(len(mesh.cells[k]) for k in cells)
        if not (smooth and n == 6 and not bad and sizes == [4] * 4 + [6] * 3):
            line = None
            if smooth and n == 6 and len(bad) == 2 and bad[1] - bad[0] == 3 and (
                    kinds[bad[0]] == kinds[bad[1]]):
                line = line_rule(mesh, cells, m, ring, bad[0])
            if line is not None:
                extra = np.zeros_like(D)
                for row, to in line.items():
                    for column, w in to.items():
                        extra[index[row], index[column]] = w
            else:
                extra = assignment(S + D, inside, wall, smooth)
        if extra is not None:
            D = D + extra
    return {v: {w: D[index[v], index[w]] for w in vertices if abs(D[index[v], index[w]]) > 1e-15}
            for v in vertices}, ring


def claims(mesh):
    """{wall vertex: {fine vertex: {coarse vertex: weight}}}: what each star asks for."""
    result = {}
    for m in mesh.wall_at:
        rows, ring = star_moves(mesh, m)
        for v, row in rows.items():
            if not row or v != m and v not in ring and v in mesh.wall_at:
                continue
            near = [k for k in mesh.star[m] if mesh.adjacent(k, m, v)]
            if v == m:
                name = ("v", m)
            elif near:
                name = ("e", frozenset((m, v)))
            else:
                name = ("o", next(k for k in mesh.star[m] if v in mesh.cells[k]))
            result.setdefault(m, {})[name] = row
    return result


def moves(asked):
    """The mean of what stars ask for, asked as from claims()."""
    rows = {}
    for star in asked.values():
        for name, row in star.items():
            rows.setdefault(name, []).append(row)
    result = {}
    for name, several in rows.items():
        total = result.setdefault(name, {})
        for row in several:
            for v, w in row.items():
                total[v] = total.get(v, 0) + w / len(several)
    return result
