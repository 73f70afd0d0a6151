# SPDX-License-Identifier: Apache-2.0
"""The installed package imports; the scripts of samples/python run and show what they promise."""
import os
import re
import subprocess
import sys

import numpy as np
import pytest

import octetvdb

SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../samples")


def run(script, *arguments):
    done = subprocess.run([sys.executable, os.path.join(SAMPLES, "python", script),
                           *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def number_after(text, output):
    return float(re.search(re.escape(text) + r"\s*([-+.\de]+)", output).group(1))


def test_the_installed_package_works(tmp_path):
    subprocess.run(["cmake", "--install", os.environ["OCTETVDB_BUILD"], "--component", "python",
                    "--prefix", str(tmp_path)], check=True, capture_output=True)
    (package,) = [folder for folder, _, files in os.walk(tmp_path) if "METADATA" in files]
    script = ("import importlib.metadata, octetvdb; print(octetvdb.__file__);"
              "assert importlib.metadata.version('octetvdb') == octetvdb.__version__;"
              "octetvdb.ControlMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])")
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True,
                          env={"PYTHONPATH": os.path.dirname(package)}, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(str(tmp_path))


def test_every_script_is_tested():
    scripts = {name for name in os.listdir(os.path.join(SAMPLES, "python"))
               if name.endswith(".py")}
    with open(__file__) as file:
        tested = set(re.findall(r'run\("(\w+\.py)"', file.read()))
    assert scripts == tested


def test_swirl(tmp_path):
    output = run("swirl_from_numpy.py", tmp_path / "swirl.vdb")
    assert number_after("divergence of the control cells:", output) < 1e-15
    assert "inside: True" in output
    assert number_after("error", output) < 2.5
    (grid,) = octetvdb.read_grid_info(str(tmp_path / "swirl.vdb"))
    assert grid.name == "velocity" and grid.metadata["octet_boundary"] == "walls"


def test_trace(tmp_path):
    output = run("trace.py", os.path.join(SAMPLES, "box/box.octet.json"), tmp_path / "paths.npy")
    paths = np.load(tmp_path / "paths.npy")
    assert f"{paths.shape[1]} still inside after 250 steps" in output
    assert (np.abs(paths) <= [1, 1, 1.5]).all()
    assert np.linalg.norm(paths[-1] - paths[0], axis=1).max() > 0.5


@pytest.mark.parametrize("name", ["mesh.vtu", "mesh.vtk"])
def test_convert(tmp_path, name):
    control = os.path.join(SAMPLES, "lattice/lattice.octet.json")
    run("convert_mesh.py", control, tmp_path / name)
    run("convert_mesh.py", tmp_path / name, tmp_path / "back.octet")
    before, after = (octetvdb.ControlAsset.read(p) for p in (control, str(tmp_path / "back.octet")))
    assert np.allclose(before.mesh.vertices, after.mesh.vertices)
    assert len(before.mesh.octahedra) == len(after.mesh.octahedra)
    for form in before.forms:
        assert np.allclose(after.form(form.name).coefficients(), form.coefficients())


def test_fit_guides(tmp_path):
    output = run("fit_guides.py", tmp_path / "rings.vdb")
    assert number_after("flux through the walls:", output) == 0
    assert number_after("lower ring:", output) < 5 and number_after("upper ring:", output) < 5
    assert octetvdb.read_grid_info(str(tmp_path / "rings.vdb"))[0].active_voxels > 10000
