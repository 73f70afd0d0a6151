#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The thesis' figures, made again: one HTML page with pictures, what each caption claims, and a
measured number beside it.

    figures.py OCTETVDB [-o FOLDER] [--quick]

Default folder: out/thesis. Needs python3-numpy and the samples. --quick: fewer levels and meshes,
small pictures; for tests.
"""
import argparse
import concurrent.futures
import html
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "boundary"))
import compare
import measure

SUPPORTS, CONTRADICTS, NOTE = "holds", "does not hold", "note"
STYLE = """body{font:16px/1.45 sans-serif;max-width:1200px;margin:2em auto;padding:0 1em;color:#222}
figure{display:inline-block;margin:0 .6em .6em 0;vertical-align:top}
figcaption{font-size:80%;color:#555}img{max-width:100%}h2{border-top:1px solid #ccc;padding-top:1em}
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.2em .6em}
td{text-align:right}td:first-child,th{text-align:left}
.holds{color:#167a2b}.does{color:#b3261e}.note,.guess{color:#555}"""


class Page:
    """Collects figures; pictures are drawn while numbers are measured."""

    def __init__(self, run, folder, quick):
        self.run, self.folder, self.quick = run, folder, quick
        self.pool = concurrent.futures.ThreadPoolExecutor(2)
        self.drawn, self.parts, self.contents, self.guessed = [], [], [], []
        self.counts = {SUPPORTS: 0, CONTRADICTS: 0, NOTE: 0}

    def levels(self, wanted):
        return min(wanted, 2) if self.quick else wanted

    def draw(self, number, label, asset, *options):
        name = f"fig_{number.replace('.', '_')}_{label.replace(' ', '_').replace(',', '')}.png"
        size = (200, 160) if self.quick else (460, 360)
        self.drawn.append(self.pool.submit(
            self.run, "preview", asset, "-o", os.path.join(self.folder, name), "--width", size[0],
            "--height", size[1], "--title", label, *options))
        return name, label

    def figure(self, number, title, claim, pictures, findings, guess=None):
        """`guess`: what about it is not told by what is left of the thesis."""
        self.contents.append((number, title))
        out = [f'<h2 id="{number}">{number} {html.escape(title)}</h2>',
               f"<p><b>Caption, in short:</b> {html.escape(claim)}</p>"]
        if guess:
            self.guessed.append(number)
            out.append(f'<p class="guess"><b>guessed:</b> {html.escape(guess)}</p>')
        for verdict, text in findings:
            self.counts[verdict] += 1
            out.append(f'<p class="{verdict}"><b>{verdict}:</b> {html.escape(text)}</p>')
        for name, label in pictures:
            out.append(f'<figure><img src="{name}" alt="{html.escape(label)}">'
                       f"<figcaption>{html.escape(label)}</figcaption></figure>")
        self.parts.append("\n".join(out))

    def table(self, head, rows):
        cells = "".join(f"<th>{html.escape(h)}</th>" for h in head)
        body = "".join("<tr>" + "".join(f"<td>{html.escape(str(c))}</td>" for c in row) + "</tr>"
                       for row in rows)
        self.parts.append(f"<table><tr>{cells}</tr>{body}</table>")

    def write(self):
        for job in self.drawn:
            job.result()
        links = " &middot; ".join(f'<a href="#{n}">{n}</a>' for n, _ in self.contents)
        guesses = ", ".join(f'<a href="#{n}">{n}</a>' for n in self.guessed)
        count = ", ".join(f"{n} {v}" for v, n in self.counts.items())
        path = os.path.join(self.folder, "index.html")
        with open(path, "w") as file:
            file.write(f"<!doctype html><meta charset=utf-8><title>The thesis, made again</title>"
                       f"<style>{STYLE}</style><h1>The thesis, made again</h1>"
                       f"<p>J. Huang, Discrete Differential Form Subdivision and Vector Field "
                       f"Generation over Volumetric Domain, Caltech 2012. Each figure as octetvdb "
                       f"makes it, with its caption's claim in our words and what was measured: "
                       f"{count}.</p><p>The copy of the thesis breaks off in section 3.3: of "
                       f"chapters 4 and 5 only captions are left, and not all of these. Every "
                       f"mesh, view and scale of theirs is ours; where a claim or a rule is a "
                       f"guess too, the figure says so: {guesses}.</p><p>{links}</p>"
                       + "\n".join(self.parts))
        return path


def found(ok, text):
    return (SUPPORTS if ok else CONTRADICTS), text


def asset_path(name):
    return os.path.join(measure.HERE, name + ".octet.json")


def write_asset(page, name, document):
    import json
    path = page.run.path(name + ".octet.json")
    with open(path, "w") as file:
        json.dump(document, file)
    return path


# ---- chapter 2 -----------------------------------------------------------------------------------
def sharpest(mesh):
    """Largest angle between neighbouring boundary facets, degrees."""
    at_edge = {}
    for f in mesh.facets[mesh.facet_on_boundary]:
        normal = np.cross(mesh.x[f[1]] - mesh.x[f[0]], mesh.x[f[2]] - mesh.x[f[0]])
        normal /= np.linalg.norm(normal)
        for k in range(3):
            at_edge.setdefault(tuple(sorted((f[k], f[k - 2]))), []).append((normal, f))
    most = 0.0
    for pair in at_edge.values():
        if len(pair) == 2:
            cosine = abs(pair[0][0] @ pair[1][0])
            most = max(most, np.degrees(np.arccos(min(1.0, cosine))))
    return most


def zero_forms(page):
    top = page.levels(4)
    plain = ["--view", "3d", "--style", "plain", "--levels", top, "--cage", "none"]
    steps = [page.run.refine(asset_path("M_E"), k, "auto", "--linear") for k in (0, top)]
    ratio = steps[1].volume() / steps[0].volume()
    same = abs(steps[1].x - page.run.refine(asset_path("M_E"), top, "expansion").x).max()
    page.figure("2.11", "Linear subdivision of M_E", "the mesh is split, its shape stays the same",
                [page.draw("2.11", f"step {k}", asset_path("M_E"), *plain, "--boundary",
                           "expansion", "--mesh-level", k) for k in range(top + 1)],
                [found(abs(ratio - 1) < 1e-12, f"volume after {top} steps / before: {ratio:.12f}"),
                 (NOTE, f"drawn with positions of the expansion method, which on this block are "
                        f"the linear ones to {same:.1e}")])
    findings, pictures = [], []
    for name in ("M_E", "M_X"):
        meshes = [page.run.refine(asset_path(name), k, "simple") for k in range(top)]
        angles = [sharpest(m) for m in meshes]
        findings.append(found(all(b < a for a, b in zip(angles, angles[1:])),
                              f"{name}: sharpest edge of the surface, degrees, step by step: "
                              + ", ".join(f"{a:.1f}" for a in angles)
                              + f"; volume left {meshes[-1].volume() / meshes[0].volume():.3f}"))
        pictures += [page.draw("2.14", f"{name} step {k}", asset_path(name), *plain, "--boundary",
                               "simple", "--mesh-level", k) for k in range(top + 1)]
    page.figure("2.14", "Smooth subdivision of M_E and M_X",
                "every step makes the mesh smoother; the rule is the cells' mean everywhere, so "
                "the mesh shrinks (Fig. 5.5)", pictures, findings)


# ---- chapter 3 -----------------------------------------------------------------------------------
def whitney(page, number, name, document, edge, facet):
    document["forms"] = [{"name": "edge", "degree": 1, "simplices": [edge], "values": [1.0]},
                         {"name": "facet", "degree": 2, "simplices": [facet], "values": [1.0]}]
    levels = page.levels(4)
    path = write_asset(page, name, document)
    fine = page.run.refine(path, levels, "auto", "--linear")
    coarse = page.run.refine(path, 0)
    worst = 0.0
    for degree, form, children in ((1, "edge", 2), (2, "facet", 4)):
        n = len(coarse.simplices(degree)) * children ** levels
        sums = fine.forms[form][:n].reshape(-1, children ** levels).sum(axis=1)
        worst = max(worst, abs(sums - coarse.forms[form]).max())
    options = ["--levels", 0, "--reconstruction", "whitney", "--view", "3d", "--style", "arrows",
               "--cage", "all"]
    page.figure(number, f"Whitney forms in the {name}",
                "the field's integral is 1 on the highlighted simplex and 0 on all others",
                [page.draw(number, f"{form}-form", path, "--form", form, *options)
                 for form in ("edge", "facet")],
                [found(worst < 1e-12, f"integrals over all edges and facets, summed over {levels} "
                                      f"linear subdivisions, are off by {worst:.1e} at most")])


def whitney_forms(page):
    base = {"octet": 1, "creases": []}
    whitney(page, "3.5", "tetrahedron",
            {**base, "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
             "tetrahedra": [[0, 1, 2, 3]]}, [1, 2], [1, 2, 3])
    whitney(page, "3.6", "octahedron",
            {**base, "vertices": [[0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0],
                                  [0, 0, -1]], "octahedra": [[0, 1, 2, 3, 4, 5]]},
            [0, 1], [0, 1, 2])


# ---- chapter 4 -----------------------------------------------------------------------------------
def regular_vertex(document):
    return [list(map(float, v)) for v in document["vertices"]].index([0.0, 0.0, 0.0])


class Zeta:
    """The spectrum at a regular vertex, and what subdivision does with one coefficient."""

    def __init__(self, page):
        self.page, self.known = page, {}
        self.vertex = regular_vertex(measure.load("M_E"))

    def growth(self, zeta, degree):
        if zeta not in self.known:
            report = self.page.run.analyse(asset_path("M_E"), self.vertex, "--zeta", zeta)
            self.known[zeta] = {d["degree"]: d for d in report["degrees"]}
        return self.known[zeta][degree]["any"]["growth"]

    def peaks(self, zeta, degree):
        """Largest field strength, level by level, in units of lattice edges or facets."""
        form, per_level = (("one_edge", 2), ("one_facet", 4))[degree - 1]
        return [abs(self.page.run.refine(asset_path("M_I"), k, "open", "--zeta", zeta)
                    .forms[form]).max() * per_level ** k
                for k in range(1, self.page.levels(3) + 1)]

    def finding(self, zeta, degree, claim):
        growth, peaks = self.growth(zeta, degree), self.peaks(zeta, degree)
        ok = {"smooth": growth <= 0.5 + 1e-6, "rough": 0.5 + 1e-6 < growth < 1,
              "blows up": growth > 1}[claim]
        return found(ok, f"zeta {zeta:g}, {degree}-form, {claim}: what is not constant changes by "
                         f"{growth:.4f} per level (at most 0.5: bounded derivatives; above 1: no "
                         f"limit); peak by level " + ", ".join(f"{p:.3g}" for p in peaks))

    def pictures(self, number, cases):
        result = []
        for zeta, degree in cases:
            form = ("one_edge", "one_facet")[degree - 1]
            for style in ("arrows", "lic"):
                result.append(self.page.draw(
                    number, f"{degree}-form zeta {zeta:g} {style}", asset_path("M_I"), "--form",
                    form, "--zeta", zeta, "--levels", self.page.levels(3), "--boundary", "open",
                    "--reconstruction", "whitney", "--style", style, "--slice", "z=0.1"))
        return result


def zeta_study(page):
    z = Zeta(page)
    page.figure("4.14", "M_I, zeta = -5", "one coefficient becomes a smooth bump",
                z.pictures("4.14", [(-5, 1), (-5, 2)]),
                [z.finding(-5, 1, "smooth"), z.finding(-5, 2, "smooth")])
    page.figure("4.15", "M_I, zeta in [-5, -7) and a little beyond", "1-forms are still smooth",
                z.pictures("4.15", [(-6, 1), (-6.9, 1), (-4.4, 1), (-7.6, 1)]),
                [z.finding(x, 1, "smooth") for x in (-6, -6.9, -4.4, -7.6)],
                guess="the claim. The caption is lost; the next one begins \"when zeta deviates "
                      "from the range [-5, -7) more\", so this one has a zeta that deviates less, "
                      "or not")
    page.figure("4.16", "Outside [-5, -7)", "1-form results start to lose smoothness",
                z.pictures("4.16", [(-3, 1), (-9, 1)]),
                [z.finding(-3, 1, "rough"), z.finding(-9, 1, "rough"),
                 (NOTE, f"a little outside the range 1-forms do not suffer yet: at zeta -4 their "
                        f"growth is {z.growth(-4, 1):.4f}, still 0.5; it is the 2-form that has "
                        f"lost its limit there (growth {z.growth(-4, 2):.4f})")])
    page.figure("4.17", "Far outside", "1-form results blow up",
                z.pictures("4.17", [(0, 1), (-12, 1)]),
                [z.finding(0, 1, "blows up"), z.finding(-12, 1, "blows up")])
    page.figure("4.18", "2-forms for different zeta", "smooth in the range, worse outside",
                z.pictures("4.18", [(-5, 2), (-6, 2), (-4.4, 2), (-3, 2)]),
                [z.finding(-6, 2, "smooth"), z.finding(-4.4, 2, "rough"),
                 z.finding(-7.6, 2, "rough"), z.finding(-3, 2, "blows up"),
                 z.finding(-9, 2, "blows up")])
    rows = [(f"{x:g}", f"{(x + 6) / 8:.4f}", f"{z.growth(x, 1):.4f}", f"{z.growth(x, 2):.4f}")
            for x in (-12, -9, -8, -7.6, -7, -6.9, -6, -5, -4.4, -4, -3, -2, 0)]
    page.table(("zeta", "p", "growth of 1-forms", "growth of 2-forms"), rows)


def eigenspace(report, degree, value):
    entry = next(d for d in report["degrees"] if d["degree"] == degree)
    for e in entry["eigenvalues"]:
        if not isinstance(e["value"], list) and abs(e["value"] - value) < 1e-6:
            return entry["simplices"], np.array(e["eigenforms"], float), e["multiplicity"]
    raise SystemExit(f"there is no eigenvalue {value} of degree {degree}")


def linear_fields(control, simplices, degree):
    """Integrals of the 12 constant and linear fields over simplices, one a row."""
    order = {tuple(s): k for k, s in enumerate(map(tuple, control.simplices(degree)))}
    rows = []
    for axis in range(3):
        for slope in (None, 0, 1, 2):
            def field(p, axis=axis, slope=slope):
                out = np.zeros_like(p)
                out[:, axis] = 1 if slope is None else p[:, slope]
                return out
            values = control.integrals(field, degree)
            rows.append([values[order[tuple(s)]] for s in simplices])
    return np.array(rows)


def eigenforms(page):
    vertex, document = regular_vertex(measure.load("M_E")), measure.load("M_E")
    control = page.run.refine(asset_path("M_E"), 0)

    def show(number, zeta, degree, value, name):
        report = page.run.analyse(asset_path("M_E"), vertex, "--vectors", "--degree", degree,
                                  "--zeta", zeta)
        simplices, forms, multiplicity = eigenspace(report, degree, value)
        path = write_asset(page, f"eigen_{number}_{degree}_{value:.4f}",
                           measure.with_forms(document, {"eigenform": (degree, simplices,
                                                                       forms[0])}))
        picture = page.draw(number, name, path, "--levels", page.levels(3), "--boundary", "open",
                            "--zeta", zeta, "--view", "3d", "--style", "arrows")
        fields = linear_fields(control, simplices, degree)
        rest = forms - np.linalg.lstsq(fields.T, forms.T, rcond=None)[0].T @ fields
        return picture, multiplicity, np.linalg.norm(rest) / np.linalg.norm(forms)

    pictures, findings = [], []
    for degree, value, what in ((1, 1 / 2, "constant"), (1, 1 / 4, "linear"),
                                (2, 1 / 4, "constant"), (2, 1 / 8, "linear")):
        picture, multiplicity, rest = show("4.19", -5, degree, value,
                                           f"{degree}-form eigenvalue {value:g}")
        pictures.append(picture)
        verdict = (found(rest < 1e-9, f"the {multiplicity} {degree}-eigenforms of {value:g} are "
                                      f"{what} fields up to {rest:.1e}") if value != 1 / 8 else
                   (NOTE, f"2-eigenforms of 1/8: {multiplicity}, linear fields and, at zeta -5, "
                          f"the three of p; {rest:.2f} of their norm is not linear"))
        findings.append(verdict)
    page.figure("4.19", "Eigenforms of eigenvalues that do not depend on zeta",
                "low-order fields, the same for every zeta", pictures, findings,
                guess="which eigenvalues; the caption says \"some\"")
    pictures, findings = [], []
    for zeta in (-4.4, -5.3, -6.7, -9):  # where p meets no other eigenvalue
        p = (zeta + 6) / 8
        picture, multiplicity, rest = show("4.20", zeta, 1, p, f"1-form zeta {zeta:g} p {p:.4f}")
        pictures.append(picture)
        findings.append(found(multiplicity >= 3 and rest > 0.5,
                              f"zeta {zeta:g}: eigenvalue p = {p:.4f}, {multiplicity} eigenforms, "
                              f"{rest:.2f} of their norm is no constant or linear field"))
    page.figure("4.20", "Eigenforms of the largest zeta-dependent eigenvalue",
                "not smooth fields: this part must die out fast, which fixes zeta", pictures,
                findings)


def extraordinary_edges(page):
    rows, growths = [], {1: [], 2: []}
    for n in range(3, 13):
        vertices = [[0, 0, -1], [0, 0, 1]] + [[np.cos(2 * np.pi * k / n), np.sin(2 * np.pi * k / n),
                                               0] for k in range(n)]
        document = {"octet": 1, "creases": [], "forms": [], "vertices": vertices,
                    "tetrahedra": [[0, 1, 2 + k, 2 + (k + 1) % n] for k in range(n)]}
        path = write_asset(page, f"edge{n}", document)
        report = {d["degree"]: d for d in page.run.analyse(path, n + 2, "--level", 1)["degrees"]}
        row = [n]
        for degree, which in ((1, "any"), (1, "closed"), (2, "any"), (2, "closed")):
            c = report[degree][which]
            row.append(f"{c['growth']:.4f} {'continuous' if c['continuous'] else 'not continuous'}")
            if which == "any":
                growths[degree].append(c["growth"])
        rows.append(row)
    page.figure("X2", "Extraordinary edges", "ours: fields are continuous on edges of every valence",
                [], [found(all("not" not in r[1] + r[2] for r in rows),
                           f"1-forms, 3 to 12 tetrahedra at the edge: what is not constant "
                           f"changes by {max(growths[1]):.4f} per level at most"),
                     found(all("not" not in r[3] + r[4] for r in rows),
                           f"2-forms, 3 to 12: by {max(growths[2]):.4f} per level at most")])
    page.table(("tetrahedra at the edge", "1-forms", "curl-free", "2-forms", "incompressible"),
               rows)


# ---- chapter 5 -----------------------------------------------------------------------------------
class Continuation:
    """How expansion continues forms of a mesh to its virtual layer: every coefficient of the
    expanded mesh, from each of the mesh's own."""

    def __init__(self, page, name):
        document = measure.load(name)
        own = page.run.refine(measure.with_forms(document, {}), 0)
        forms = {f"{degree} {k}": (degree, [s], [1.0])
                 for degree in (1, 2) for k, s in enumerate(own.simplices(degree))}
        self.mesh = page.run.refine(measure.with_forms(document, forms), 0, "expansion",
                                    "--virtual-layer")
        self.own = own
        self.rows = {degree: np.array([self.mesh.forms[f"{degree} {k}"] for k in
                                       range(len(own.simplices(degree)))]).T for degree in (1, 2)}
        real = len(own.x)     # vertices of the mesh itself come first
        sorted_own = {d: set(map(tuple, np.sort(own.simplices(d), axis=1))) for d in (1, 2)}
        self.virtual = {d: np.array([tuple(sorted(s)) not in sorted_own[d] for s in
                                     self.mesh.simplices(d)]) for d in (1, 2)}
        self.added = len(self.mesh.x) - real

    def copies(self, degree):
        """Of the virtual simplices: how many there are, how many read parallel ones only, and the
        mean part of the weights that lies on parallel ones."""
        theirs = self.mesh.vectors_of_simplices(degree)[self.virtual[degree]]
        ours = self.own.vectors_of_simplices(degree)
        weights = abs(self.rows[degree][self.virtual[degree]])
        across = np.linalg.norm(np.cross(theirs[:, None], ours[None]), axis=2)
        on_parallel = (weights * (across < 1e-9)).sum(axis=1) / weights.sum(axis=1)
        return len(theirs), int((on_parallel > 1 - 1e-9).sum()), on_parallel.mean()

    def commutes(self):
        """Largest difference between d of a continued 1-form and the continued d of it."""
        own, larger = (derivative(m) for m in (self.own, self.mesh))
        return abs(larger @ self.rows[1] - self.rows[2] @ own).max()

    def asset(self, page, degree, which):
        """The expanded mesh, with one of the mesh's coefficients continued."""
        document = {"octet": 1, "creases": [], "vertices": self.mesh.x.tolist(),
                    "tetrahedra": self.mesh.tets.tolist(), "octahedra": self.mesh.octs.tolist()}
        values = self.rows[degree][:, which]
        kept = np.flatnonzero(values)
        return write_asset(page, f"continued_{degree}", measure.with_forms(document, {
            "continued": (degree, self.mesh.simplices(degree)[kept], values[kept])}))


def derivative(mesh):
    """d of 1-forms as a matrix, facets by edges."""
    edge = {tuple(e): k for k, e in enumerate(mesh.edges)}
    result = np.zeros((len(mesh.facets), len(mesh.edges)))
    for row, (a, b, c) in zip(result, mesh.facets):
        for pair in ((a, b), (b, c), (c, a)):
            if pair in edge:
                row[edge[pair]] += 1
            else:
                row[edge[pair[::-1]]] -= 1
    return result


def continuation(page):
    c = Continuation(page, "M_E")
    options = ["--levels", 0, "--reconstruction", "whitney", "--view", "3d", "--style", "arrows",
               "--cage", "all"]
    pictures, findings = [], []
    for degree, name in ((1, "edge"), (2, "facet")):
        outer = c.own.edge_on_boundary if degree == 1 else c.own.facet_on_boundary
        which = int(np.flatnonzero(outer)[0])
        alone = write_asset(page, f"alone_{degree}", measure.with_forms(
            measure.load("M_E"), {"one": (degree, [c.own.simplices(degree)[which]], [1.0])}))
        pictures += [page.draw("5.17", f"one {name}", alone, *options),
                     page.draw("5.17", f"one {name} continued", c.asset(page, degree, which),
                               *options)]
        total, parallel, part = c.copies(degree)
        findings.append(found(parallel == total,
                              f"of {total} virtual {name}s {parallel} read parallel real ones only; "
                              f"on average {100 * part:.0f} % of its weights are on these, "
                              f"the rest keeps d"))
    findings.append((NOTE, f"{c.added} virtual vertices around M_E; continuing commutes with d to "
                           f"{c.commutes():.1e}, which copies alone do not"))
    page.figure("5.17", "Where virtual coefficients come from",
                "virtual simplices copy the coefficient of a parallel real one", pictures, findings,
                guess="the claim and the number. Of the captions 5.16 to 5.18 one line is left, "
                      "\"in the virtual mesh to which we copy the coefficient\". Which real simplex "
                      "is copied is lost; core/thesis/extension.h says what is done "
                      "instead")


def boundary_methods(page):
    names = ["M_E"] if page.quick else ["M_E", "M_X", "M_B", "ball"]
    table = compare.compare(page.run, compare.LEVELS, names)
    b = table["M_E" if page.quick else "M_B"]
    top = page.levels(3)

    def pictures(number, asset, method, forms, slice_only=False):
        result = []
        for form in forms:
            common = ["--form", form, "--boundary", method, "--levels", top]
            result.append(page.draw(number, f"{form} slice", asset_path(asset), *common, "--style",
                                    "arrows", "--slice", "z=0.1"))
            if not slice_only:
                result.append(page.draw(number, f"{form} streamlines", asset_path(asset), *common,
                                        "--view", "3d", "--style", "streamlines"))
        return result

    flows = ("circulation", "flux")
    fine = page.run.refine(asset_path("M_B"), top, "simple")
    left = max(abs(fine.forms["flux"][fine.facet_on_boundary]).max(),
               abs(fine.forms["circulation"][fine.edge_on_boundary]).max())
    page.figure("5.3", "M_B by the simple method", "boundary coefficients are set to 0",
                pictures("5.3", "M_B", "simple", flows),
                [found(left == 0, f"largest boundary coefficient after {top} steps: {left:g}")])
    page.figure("5.4", "Its details near the boundary", "fields attenuate and vanish there",
                pictures("5.4", "M_B", "simple", flows, True),
                [found(b["simple"]["attenuation"] < 0.9,
                       f"of a constant flux {b['simple']['attenuation']:.3f} is left next to the "
                       f"boundary; by expansion {b['expansion']['attenuation']:.3f}")])
    one, same = (page.run.refine(asset_path("M_I"), top, m).forms["one_edge"]
                 for m in ("projection", "open"))
    off = abs(one - same).max() / abs(same).max()
    page.figure("5.6", "M_I by the projection method", "inside, the field is that of Fig. 4.14",
                pictures("5.6", "M_I", "projection", ("one_edge",)),
                [found(off < 0.01, f"circulations differ from those of Fig. 4.14, by the open rule, "
                                   f"by {off:.2g} of the peak at most")],
                guess="the claim: the caption has none. The rule, but for its name and Fig. 5.5's "
                      "caption: core/thesis/thesis_subdivision.h")
    page.figure("5.7", "M_B by projection with scaling",
                "no attenuation, but streamlines bend at the boundary",
                pictures("5.7", "M_B", "projection", flows),
                [found(abs(b["projection"]["attenuation"] - 1) < 0.01,
                       f"of a constant flux {b['projection']['attenuation']:.4f} is left"),
                 found(b["projection"]["bending"] > b["expansion"]["bending"],
                       f"a turning flow is turned by {b['projection']['bending']:.1f} degrees at "
                       f"the boundary; by expansion {b['expansion']['bending']:.1f}")],
                guess="the claim, from what Fig. 5.19 says is gone: attenuation, enlarging or bend")
    plain = ["--view", "3d", "--style", "plain", "--boundary", "expansion", "--levels",
             page.levels(3)]
    for number, name in (("5.14", "M_E"), ("5.15", "M_X")):
        meshes = [page.run.refine(asset_path(name), k, "expansion") for k in (0, page.levels(3))]
        ratio = meshes[1].volume() / meshes[0].volume()
        page.figure(number, f"{name} by the expansion method", "the mesh does not shrink",
                    [page.draw(number, f"{name} step {k}", asset_path(name), *plain,
                               "--mesh-level", k) for k in range(page.levels(3) + 1)],
                    [found(abs(ratio - 1) < (1e-12 if name == "M_E" else 0.05),
                           f"volume after / before: {ratio:.6f}")])
    continuation(page)
    page.figure("5.19", "M_B by the extension method",
                "no attenuation, no enlarging, no bending",
                pictures("5.19", "M_B", "expansion", flows),
                [found(abs(b["expansion"]["attenuation"] - 1) < 1e-9,
                       f"of a constant flux {b['expansion']['attenuation']:.9f} is left; constants "
                       f"are off by {b['expansion']['constants']:.1e}"),
                 found(b["expansion"]["bending"] <= min(b[m]["bending"] for m in compare.METHODS),
                       f"bending {b['expansion']['bending']:.1f} degrees, of all methods: "
                       + ", ".join(f"{m} {b[m]['bending']:.1f}" for m in compare.METHODS))])
    page.figure("5.20", "Its details near the boundary", "the field does not attenuate",
                pictures("5.20", "M_B", "expansion", flows, True),
                [found(abs(b["expansion"]["attenuation"] - 1) < 1e-9,
                       f"left next to the boundary: {b['expansion']['attenuation']:.9f}")])
    kept = {m: max(rows[m]["constants"] for rows in table.values()) for m in compare.METHODS}
    page.figure("boundary", "Five ways at the boundary, measured", "ours; see boundary/compare.py",
                [], [(NOTE, f"after {compare.LEVELS} steps; errors relative to the largest "
                            f"coefficient. Constants are off, at most, by "
                            + ", ".join(f"{v:.1e} ({m})" for m, v in kept.items()))])
    for mesh, rows in table.items():
        head = [mesh] + list(next(iter(rows.values())))
        page.table(head, [[m] + [f"{v:.3g}" for v in n.values()] for m, n in rows.items()])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("octetvdb")
    parser.add_argument("-o", "--output", default=os.path.join("out", "thesis"))
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    os.makedirs(arguments.output, exist_ok=True)
    page = Page(measure.Octetvdb(arguments.octetvdb), arguments.output, arguments.quick)
    for part in (zero_forms, whitney_forms, zeta_study, eigenforms, extraordinary_edges,
                 boundary_methods):
        part(page)
    print(page.write())
    print(", ".join(f"{n} {v}" for v, n in page.counts.items()))


if __name__ == "__main__":
    main()
