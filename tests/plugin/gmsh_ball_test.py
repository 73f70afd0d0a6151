#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A ball that the real Gmsh meshes and writes in each format: described alike, refined and baked.
Arguments: the octetvdb command."""
import json
import math
import os
import unittest

import gmsh

import command

OCTETVDB = command.from_arguments()
# Extension, version and binary or not, as Gmsh's options say it.
FORMATS = [("msh", 2.2, 0), ("msh", 2.2, 1), ("msh", 4.1, 0), ("msh", 4.1, 1), ("mesh", 0, 0),
           ("vtk", 0, 0), ("vtk", 0, 1)]


def write_balls(folder):
    """A ball of radius 1 with a scalar at the nodes, in every format."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("ball")
    ball = gmsh.model.occ.addSphere(0, 0, 0, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(3, [ball])
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.5)
    gmsh.model.mesh.generate(3)
    tags, points, _ = gmsh.model.mesh.getNodes()
    view = gmsh.view.add("height")
    gmsh.view.addModelData(view, 0, "ball", "NodeData", tags, [[z] for z in points[2::3]])
    paths = []
    for extension, version, binary in FORMATS:
        path = os.path.join(folder, f"ball-{version}-{binary}.{extension}")
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.Binary", binary)
        gmsh.option.setNumber("PostProcessing.SaveMesh", 0)
        gmsh.write(path)
        if extension == "msh":
            gmsh.view.write(view, path, append=True)
        paths.append(path)
    gmsh.finalize()
    return paths


class Ball(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = command.temporary_folder()
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = temporary.name
        cls.paths = write_balls(cls.folder)

    def json(self, *arguments):
        result = OCTETVDB.run(*arguments, "--json")
        self.assertEqual(result.returncode, 0, result.stderr)
        return json.loads(result.stdout)

    def test_every_format_describes_the_same_ball(self):
        reports = [self.json("info", path) for path in self.paths]
        first = reports[0]
        self.assertGreater(first["tetrahedra"], 100)
        self.assertEqual(first["octahedra"], 0)
        self.assertLess(first["volume"], 4 / 3 * math.pi)
        self.assertGreater(first["volume"], 0.8 * 4 / 3 * math.pi)
        for report, path in zip(reports, self.paths):
            for key in ("vertices", "edges", "facets", "tetrahedra", "boundary_facets",
                        "vertex_types"):
                self.assertEqual(report[key], first[key], path)
            self.assertAlmostEqual(report["volume"], first["volume"], delta=1e-6)

    def test_data_of_its_nodes_is_a_form_that_can_be_baked(self):
        for path in self.paths:
            if not path.endswith(".msh"):
                continue
            form, = self.json("info", path)["forms"]
            self.assertEqual((form["name"], form["degree"]), ("height", 0))
            self.assertAlmostEqual(form["max"], 1, delta=1e-6)
            out = os.path.join(self.folder, "out.vdb")
            grid, = self.json("bake", path, "-o", out, "--resolution", "20")["files"][0]["grids"]
            # The smooth ball is a little smaller than its cage.
            self.assertAlmostEqual(grid["max"], 0.9, delta=0.1)
            self.assertAlmostEqual(grid["min"], -0.9, delta=0.1)
            volume = grid["active_voxels"] * grid["voxel_size"] ** 3
            self.assertAlmostEqual(volume / (4 / 3 * math.pi), 0.8, delta=0.15)


if __name__ == "__main__":
    unittest.main()
