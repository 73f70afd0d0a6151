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
# Barycentric coordinates of a sample that only one side finds: rounding, if smaller than this.
NEAR_BOUNDARY = 1e-6


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
    """The image and the seconds of the fastest of several updates."""
    resampler = vtk.vtkResampleToImage()
    resampler.SetInputDataObject(mesh)
    resampler.SetUseInputBounds(False)
    resampler.SetSamplingBounds(low[0], high[0], low[1], high[1], low[2], high[2])
    resampler.SetSamplingDimensions(resolution, resolution, resolution)
    times = []
    for _ in range(REPETITIONS):
        resampler.Modified()
        start = time.perf_counter()
        resampler.Update()
        times.append(time.perf_counter() - start)
    return resampler.GetOutput(), min(times)


def farthest_from_boundary(samples, points, tets):
    """How deep the deepest of the samples lies in a tetrahedron, as a barycentric coordinate."""
    origin = points[tets[:, 0]]
    edges = np.moveaxis(points[tets[:, 1:]] - origin[:, None], 1, 2)
    inverse = np.linalg.inv(edges)
    deepest = -np.inf
    for x in samples:
        tail = np.einsum("nij,nj->ni", inverse, x - origin)
        depth = np.minimum(tail.min(axis=1), 1 - tail.sum(axis=1)).max()
        deepest = max(deepest, depth)
    return deepest


def compare(grid, samples, inside, image, points, tets):
    data = image.GetPointData()
    array = data.GetArray("vectors")
    theirs = vtk_to_numpy(array)
    found = vtk_to_numpy(data.GetArray("vtkValidPointMask")) == 1
    both = inside & found
    largest = np.abs(samples).max()
    difference = np.abs(samples[both] - theirs[both]).max() / largest
    print(f"VTK {vtk.vtkVersion.GetVTKVersion()}, {array.GetDataTypeAsString()} values, "
          f"{vtk.vtkSMPTools.GetBackend()} on {vtk.vtkSMPTools.GetEstimatedNumberOfThreads()} thread")
    print(f"samples inside for both: {both.sum()}, largest difference {difference:.1e} of max |v|")
    n = grid["resolution"]
    for name, only in (("OctetVDB", inside & ~found), ("VTK", found & ~inside)):
        at = np.flatnonzero(only)
        print(f"samples only {name} finds: {len(at)}", end="")
        if len(at):
            ijk = np.stack([at % n, at // n % n, at // (n * n)], axis=1)
            x = np.array(grid["origin"]) + grid["spacing"] * ijk
            depth = farthest_from_boundary(x[:1000], points, tets)
            where = "on" if abs(depth) < NEAR_BOUNDARY else "OFF"
            print(f", {where} the boundary: barycentric coordinate at most {depth:.1e}", end="")
        print()


def main(folder):
    vtk.vtkSMPTools.SetBackend("Sequential")
    vtk.vtkSMPTools.Initialize(1)
    grid, points, vectors, tets, samples, inside = load(folder)
    n = grid["resolution"]
    low = np.array(grid["origin"])
    high = low + grid["spacing"] * (n - 1)  # both ends of VTK's bounds are samples
    image, seconds = resample(unstructured_grid(points, vectors, tets), low, high, n)
    assert image.GetDimensions() == (n, n, n)
    assert np.array_equal(image.GetOrigin(), low)
    assert np.allclose(image.GetSpacing(), grid["spacing"], rtol=1e-15, atol=0)
    print(f"{grid['mesh']}: {grid['cells']} cells, {len(tets)} tetrahedra, {n}^3 samples")
    compare(grid, samples, inside, image, points, tets)
    rate = n**3 / 1e6
    print(f"VTK sampling: {rate / seconds:.2f} million points/s")
    print(f"OctetVDB sampling: {rate / grid['seconds']:.2f} million points/s, "
          f"{rate / grid['seconds_two_threads']:.2f} on two threads")
    print(f"sampling ratio: {seconds / grid['seconds']:.1f} x")


if __name__ == "__main__":
    main(sys.argv[1])
