"""Whole runs with meshes as masters: a tyre, a soft torus, a ball beside its exact twin."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.sample import full

import contiga as cg
from contiga.io.out.vtkhdf import read_fields

UNITS = '[units]\nlength = "m"\nmass = "kg"\ntime = "s"\n'
QUIET = "[output]\nevery = 10\nreport = false\n"


def _signed_distance(mesh: cg.TriMesh, points: np.ndarray) -> np.ndarray:
    """By VTK: negative inside."""
    vtk = pytest.importorskip("vtk")
    support = pytest.importorskip("vtk.util.numpy_support")
    poly, at, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    at.SetData(support.numpy_to_vtk(mesh.vertices, deep=True))
    for t in mesh.triangles:
        cells.InsertNextCell(3, t.tolist())
    poly.SetPoints(at)
    poly.SetPolys(cells)
    distance = vtk.vtkImplicitPolyDataDistance()
    distance.SetInput(poly)
    return np.array([distance.EvaluateFunction(p.tolist()) for p in points])


@pytest.mark.full
def test_road_pressed_into_a_tyre_of_solids(
    run_case: Callable, physics: Callable, data_dir: Path
) -> None:
    """The tyre's own skin is the master: what VTK finds inside it is in contact, no deeper."""
    run = run_case(f"""
title = "Road against tyre"
{UNITS}
[time]
end = 1.0
step = 0.1
[[body]]
name = "tyre"
geometry = {{ mesh = "{data_dir / "hmmwv_lugged_tyre_c3d10.inp"}" }}
motion = {{ kind = "rotate", axis = "x", table = [[0, 0], [1, 8]] }}
[[slave]]
name = "road"
points = {{ grid = {{ shape = "plane", width = 0.5, length = 0.6, centre = [0, 0, -0.72], \
nu = 26, nv = 31 }} }}
motion = {{ kind = "translate", table = [[0, 0, 0, 0], [0.5, 0, 0, 0.02], [1, 0, 0, -0.02]] }}
[[contact]]
master = "tyre"
slave = "road"
law = {{ kind = "stress", elastic = 2e5, thickness = 0.05 }}
{QUIET}""")
    physics(run, corners=True)
    assert run.history["n_contact"].max() >= 20
    assert run.history["n_contact"][[0, -1]].tolist() == [0, 0]
    states = [run.states[k] for k in (3, 5, 7)]
    distances = _signed_distance(run.body, np.concatenate([state.points_B for state in states]))
    for state, distance in zip(states, np.split(distances, 3), strict=True):
        np.testing.assert_array_equal(state.in_contact, distance < 0.0)
        # The tracked foot is a local minimum, never closer than the closest point.
        assert (state.penetration >= np.maximum(-distance, 0.0) - 1e-7).all()
    assert (run.history["force_z"][run.history["n_contact"] > 0] < 0.0).all()


def test_cloud_found_inside_a_soft_torus_by_penetration(
    run_case: Callable, physics: Callable, data_dir: Path
) -> None:
    run = run_case(f"""
title = "Cloud in torus"
{UNITS}
[time]
end = 1.0
step = 0.25
[[body]]
name = "torus"
geometry = {{ mesh = "{data_dir / "torus_tet4.vtk"}", transform = [{{ scale = 10.0 }}] }}
motion = {{ kind = "rotate", axis = [1, 2, 0], table = [[0, 0], [1, 50]] }}
[[slave]]
name = "cloud"
points = {{ random = {{ box = [[-2, -2, -2], [2, 2, 2]], n = 3000, seed = 1 }} }}
[[contact]]
master = "torus"
slave = "cloud"
search = "penetration"
law = {{ kind = "penalty", stiffness = 1.0 }}
area = {{ kind = "constant", value = 0.1 }}
{QUIET}""")
    assert run.history["n_contact"].min() > 5
    start = run.states[0]
    distance = _signed_distance(run.body, start.points_B)
    np.testing.assert_array_equal(start.in_contact, distance < 0.0)
    np.testing.assert_allclose(start.penetration, np.maximum(-distance, 0.0), rtol=0, atol=1e-6)
    for state in run.states:
        np.testing.assert_array_equal(state.in_contact, run.body.contains(state.points_B))


CASE = """
title = "Ball on sheet"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 2.0, step = 0.25 }
[[body]]
name = "ball"
GEOMETRY
reference_point = [0, 0, 1]
motion = { kind = "translate", table = [[0, 0, 0, 10.4], [1, 0, 0, 9], [2, 0, 0, 10.4]] }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 12, length = 12, nu = 41, nv = 41 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "penalty", stiffness = 1.0, per_area = true }
"""


@pytest.mark.parametrize("suffix", [".vtu", *full(".msh", ".stl")])
def test_mesh_of_a_ball_comes_to_the_forces_of_the_ball(tmp_path: Path, suffix: str) -> None:
    from contiga.io.out.write_mesh import write_mesh

    ball = cg.shapes.sphere(radius=10.0)
    case = tmp_path / "case.toml"
    case.write_text(CASE.replace("GEOMETRY", 'geometry = { shape = "sphere", radius = 10 }'))
    exact = cg.run(case, out=None).history
    errors = []
    for tol in (0.05, 0.005):
        write_mesh(tmp_path / f"ball{suffix}", ball.tessellate(tol))
        case.write_text(CASE.replace("GEOMETRY", f'geometry = {{ mesh = "ball{suffix}" }}'))
        result = cg.run(case, out=tmp_path / "out")
        errors.append(np.abs(result.history["force"] - exact["force"]).max())
    assert errors[0] < 0.15 * exact["force"].max()
    assert errors[1] < 0.3 * errors[0]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["inputs"]["ball"]["kind"] == "mesh"
    assert summary["inputs"]["ball"]["closed"]
    assert "ball" in (tmp_path / "out" / "report.html").read_text()
    fields = read_fields(tmp_path / "out" / "fields.vtkhdf")
    assert len(fields.times) == 9
    assert len(fields.points(0)) == summary["n_points"] + len(
        np.unique(ball.tessellate(0.005).triangles)
    )


def test_a_stopped_run_on_a_mesh_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    ball = cg.shapes.sphere(radius=10.0).tessellate(0.02)
    meshio.write(tmp_path / "ball.vtu", meshio.Mesh(ball.vertices, [("triangle", ball.triangles)]))
    case = tmp_path / "case.toml"
    case.write_text(
        CASE.replace("GEOMETRY", 'geometry = { mesh = "ball.vtu", normals = "vertex" }')
    )
    whole = cg.run(case, out=tmp_path / "whole")

    def stop(done: int, *_: int) -> None:
        if done == 4:
            raise KeyboardInterrupt

    from contiga.case.build import run
    from contiga.simulation.run import RunOptions

    with pytest.raises(KeyboardInterrupt):
        run(cg.load_case(case), tmp_path / "parts", RunOptions(progress=stop))
    again = cg.run(case, out=tmp_path / "parts", resume=True)
    for name, column in whole.history.items():
        if not name.endswith("wall_time"):
            np.testing.assert_array_equal(column, again.history[name], err_msg=name)
    # Other normals are another case.
    case.write_text(case.read_text().replace('"vertex"', '"facet"'))
    with pytest.raises(cg.errors.CheckpointError):
        cg.run(case, out=tmp_path / "parts", resume=True)
