# SPDX-License-Identifier: Apache-2.0
"""Samples a field from export_field with vtkResampleToImage, on one thread, and compares.

usage: /usr/bin/python3 vtk_resample.py FOLDER
"""
import json
import sys
import time

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy

REPETITIONS = 3
# Of values, relative to the largest.
ROUNDING = 1e-12
# VTK's probe takes a sample for inside a cell that it misses by a thousandth of the cell's size, and
# extrapolates (CELL_TOLERANCE_FACTOR_SQR in vtkProbeFilter.cxx). Barycentric coordinates of flat
# tetrahedra are that much larger.
VTK_TOLERANCE = 1e-3
FLATTEST = 30
# So many samples that differ are looked at more closely, the worst first.
CHECKED = 300


def load(folder):
    read = lambda name, kind: np.fromfile(f"{folder}/{name}", dtype=kind)
    with open(f"{folder}/grid.json") as file:
        grid = json.load(file)
    return (grid, read("points.f64", "f8").reshape(-1, 3), read("vectors.f64", "f8").reshape(-1, 3),
            read("tetrahedra.i32", "i4").reshape(-1, 4), read("samples.f64", "f8").reshape(-1, 3),
            read("inside.u8", "u1") == 1)


def unstructured_grid(points, vectors, tets):
    mesh = vtk.vtkUnstructuredGrid()
    vertices = vtk.vtkPoints()
    vertices.SetData(numpy_to_vtk(points, deep=True))
    mesh.SetPoints(vertices)
    cells = vtk.vtkCellArray()
    cells.SetData(4, numpy_to_vtkIdTypeArray(tets.astype(np.int64).ravel(), deep=True))
    mesh.SetCells(vtk.VTK_TETRA, cells)
    data = numpy_to_vtk(vectors, deep=True)
    data.SetName("vectors")
    mesh.GetPointData().AddArray(data)
    return mesh


def resample(mesh, low, high, resolution):
    """The image, the median seconds of processor time of several updates, and of the wall clock."""
    resampler = vtk.vtkResampleToImage()
    resampler.SetInputDataObject(mesh)
    resampler.SetUseInputBounds(False)
    resampler.SetSamplingBounds(low[0], high[0], low[1], high[1], low[2], high[2])
    resampler.SetSamplingDimensions(resolution, resolution, resolution)
    times = []
    for _ in range(REPETITIONS):
        resampler.Modified()
        start = time.process_time(), time.perf_counter()
        resampler.Update()
        times.append((time.process_time() - start[0], time.perf_counter() - start[1]))
    return (resampler.GetOutput(), *np.median(times, axis=0))


class Tetrahedra:
    """Linear interpolation of the vectors in single tetrahedra, to tell who is right."""

    def __init__(self, points, vectors, tets):
        self.vectors, self.tets, self.origin = vectors, tets, points[tets[:, 0]]
        edges = np.moveaxis(points[tets[:, 1:]] - self.origin[:, None], 1, 2)
        self.inverse = np.linalg.inv(edges)

    def barycentric(self, x):
        """In all tetrahedra; column 0 belongs to the first vertex."""
        tail = np.einsum("nij,nj->ni", self.inverse, x - self.origin)
        return np.column_stack([1 - tail.sum(axis=1), tail])

    def values(self, x, tolerance):
        """Depths, as least barycentric coordinates, and values of the tetrahedra that x lies in or
        misses by the tolerance; the deepest first."""
        barycentric = self.barycentric(x)
        depth = barycentric.min(axis=1)
        near = np.flatnonzero(depth > -tolerance)
        near = near[np.argsort(-depth[near])]
        return depth[near], np.einsum("ni,nic->nc", barycentric[near],
                                      self.vectors[self.tets[near]])


def compare(grid, samples, inside, image, tetrahedra):
    """Prints how far the samples agree; false if a difference is not VTK's tolerance."""
    data = image.GetPointData()
    theirs = vtk_to_numpy(data.GetArray("vectors"))
    found = vtk_to_numpy(data.GetArray("vtkValidPointMask")) == 1
    both = inside & found
    largest = np.abs(samples).max()
    error = np.where(both, np.abs(samples - theirs).max(axis=1) / largest, 0)
    n = grid["resolution"]

    def near(at):
        ijk = np.array([at % n, at // n % n, at // (n * n)])
        return tetrahedra.values(np.array(grid["origin"]) + grid["spacing"] * ijk,
                                 VTK_TOLERANCE * FLATTEST)

    off = np.flatnonzero(error > ROUNDING)
    worst = off[np.argsort(-error[off])][:CHECKED]
    ours_exact = theirs_near = 0.0
    for at in worst:
        depth, values = near(at)
        ours_exact = max(ours_exact, np.abs(values[0] - samples[at]).max() / largest)
        theirs_near = max(theirs_near, np.abs(values - theirs[at]).max(axis=1).min() / largest)
    agree = ours_exact < ROUNDING and theirs_near < ROUNDING
    print(f"  values: {both.sum() - len(off)} of {both.sum()} samples agree to {ROUNDING:g} of "
          "max |v|")
    if len(off):
        print(f"  the other {len(off)} differ by {error.max():.1e} at most: VTK extrapolates from a "
              f"neighbouring tetrahedron, within its tolerance\n  of {VTK_TOLERANCE:g} of a cell; "
              f"of the {len(worst)} worst, ours are within {ours_exact:.0e} of the tetrahedron that "
              f"holds the sample,\n  VTK's within {theirs_near:.0e} of a neighbour")
    for name, only in (("OctetVDB", inside & ~found), ("VTK", found & ~inside)):
        at = np.flatnonzero(only)
        if len(at):
            depths = [near(k)[0] for k in at[:CHECKED]]
            deepest = max(d[0] if len(d) else -np.inf for d in depths)
            print(f"  {len(at)} samples only {name} finds: at most {deepest:.0e} deep, as a "
                  "barycentric coordinate")
            agree = agree and deepest < 1e-9
    return agree


def main(folder):
    vtk.vtkSMPTools.SetBackend("Sequential")
    vtk.vtkSMPTools.Initialize(1)
    grid, points, vectors, tets, samples, inside = load(folder)
    n = grid["resolution"]
    low = np.array(grid["origin"])
    high = low + grid["spacing"] * (n - 1)  # both ends of VTK's bounds are samples
    image, seconds, wall = resample(unstructured_grid(points, vectors, tets), low, high, n)
    assert image.GetDimensions() == (n, n, n)
    assert np.array_equal(image.GetOrigin(), low)
    assert np.allclose(image.GetSpacing(), grid["spacing"], rtol=1e-15, atol=0)
    rate = n**3 / 1e6
    print(f"{grid['mesh']}: {grid['cells']} cells as {len(tets)} tetrahedra, {n}^3 samples, "
          f"{inside.mean():.0%} of them inside; one thread, processor time")
    print(f"  VTK {vtk.vtkVersion.GetVTKVersion()}: {rate / seconds:.2f} million points/s; "
          f"OctetVDB: {rate / grid['seconds']:.1f} million points/s")
    print(f"  sampling ratio: {seconds / grid['seconds']:.1f} x   (by the wall clock "
          f"{wall / grid['wall_seconds']:.1f} x)")
    if not compare(grid, samples, inside, image, Tetrahedra(points, vectors, tets)):
        sys.exit("the samples differ")


if __name__ == "__main__":
    main(sys.argv[1])
