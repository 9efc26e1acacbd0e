"""Slaves with a geometry in a case: shapes and CAD as surfaces of splines, or as triangles."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from tests import occ_solids

import contiga as cg
from contiga.case.schema import parse_case
from contiga.errors import InputError

CASE = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.1, step = "auto" }
[[slave]]
name = "sheet"
GEOMETRY
[slave.motion]
kind = "deform"
material = { kind = "elastic", young = 100.0, poisson = 0.3 }
density = 1.0e-3
thickness = 1.0
fixed = { edge = "u0", slope = true }
"""
PLANE = 'geometry = { shape = "plane", width = 20, length = 10 }'


def strip(degree: int, weights: list[list[float]]) -> str:
    """A rectangle as NURBS, of all but its last row of control points on its edge u0."""
    knots = [0.0] * (degree + 1) + [1.0] * (degree + 1)
    rows = [[[0, 0, 0], [0, 1, 0]]] * degree + [[[1, 0, 0], [1, 1, 0]]]
    return (
        f"geometry.nurbs = {{ degrees = [{degree}, 1], knots = [{knots}, [0, 0, 1, 1]], "
        f"control_points = {rows}, weights = {weights} }}"
    )


def sheet(geometry: str, folder: Path = Path("."), text: str = CASE) -> cg.Slave:
    case = parse_case(text.replace("GEOMETRY", geometry), folder / "case.toml")
    return cg.build(case).slaves["sheet"].slave


def test_a_shape_is_a_surface_with_elements_of_a_tenth() -> None:
    (patch,) = sheet(PLANE).surfaces.patches
    assert patch.degrees == (2, 2)
    assert [len(np.unique(knots)) - 1 for knots in patch.knots] == [9, 5]


def test_refine_says_degree_and_elements() -> None:
    (patch,) = sheet(PLANE + "\nrefine = { degree = 3, elements = [4, 2] }").surfaces.patches
    assert patch.degrees == (3, 3)
    assert [len(np.unique(knots)) - 1 for knots in patch.knots] == [4, 2]


def test_untrimmed_faces_of_a_step_file_are_patches(tmp_path: Path) -> None:
    """The side of a cylinder is; its ends are trimmed, and refused or meshed on request."""
    path = occ_solids.write(occ_solids.cylinder(10.0, 20.0, (0, 0, 0)), tmp_path / "tube.step")
    whole = f'geometry = {{ file = "{path.name}" }}'
    side = whole.replace(" }", ", faces = [1] }")
    held = CASE.replace('edge = "u0"', 'edge = "v0"')
    slave = sheet(side + "\nrefine = { size = 4.0 }", tmp_path, held)
    assert np.abs(np.hypot(*slave.points[:, :2].T) - 10.0).max() < 1e-9
    with pytest.raises(InputError, match=r"2 of 3 faces are trimmed.*mesh = \{ size \}"):
        sheet(whole, tmp_path)
    loose = re.sub("fixed = .*", "", CASE)
    meshed = sheet(whole + "\nmesh = { size = 4.0 }", tmp_path, loose)
    assert meshed.surfaces is None
    assert float(meshed.area.sum()) == pytest.approx(600.0 * np.pi, rel=0.01)


def test_a_case_runs(tmp_path: Path) -> None:
    text = CASE.replace("GEOMETRY", PLANE) + "velocity = [0, 0, -1]\n"
    result = cg.run(parse_case(text), tmp_path / "out")
    state = result.state.slaves["sheet"]
    slave = cg.build(parse_case(text)).slaves["sheet"].slave
    edge = slave.surfaces.edge("u0")
    np.testing.assert_array_equal(state.points[edge], slave.points[edge])
    assert state.points[:, 2].min() == pytest.approx(-0.1, rel=0.2)


@pytest.mark.parametrize(
    ("geometry", "told"),
    [
        ('geometry = { shape = "sphere", radius = 5 }', "edge v0 is a pole"),
        (PLANE + "\npoints = { coordinates = [[0, 0, 0]] }", "exactly one of the keys points or"),
        ("", "exactly one of the keys points or geometry; found 'neither'"),
        (PLANE + "\nrefine = { elements = [2, 2], size = 1.0 }", "says twice how long"),
        (PLANE + "\nrefine = { degree = 6 }", "refine.degree"),
        (PLANE + "\nrefine = {}\nmesh = {}", "one of them"),
        ("points = { coordinates = [[0, 0, 0]] }\nmesh = {}", "mesh: is for a geometry"),
        (
            'geometry.patches = [{ shape = "plane" }, { shape = "plane", centre = [5, 0, 0] }]',
            "do not meet the others",
        ),
        (
            'geometry.patches = [{ shape = "plane" }, { shape = "plane", centre = [1, 0.5, 0] }]',
            "they meet along a part of an edge",
        ),
        (strip(1, [[1, 1], [1, 0]]), r"weight at \(1, 1\) must be positive"),
        (strip(1, [[1, -1], [1, 1]]), r"weight at \(0, 1\) must be positive"),
        (strip(2, [[1, 1], [1, 1], [1, 1]]), "edge u0 is degenerate"),
    ],
)
def test_what_is_wrong_is_told_by_check(geometry: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        sheet(geometry)


def test_an_edge_that_is_not_there_is_told() -> None:
    with pytest.raises(
        InputError, match=r'slave\[0\].motion.fixed.0..edge.*"u0", "u1", "v0", "v1"'
    ):
        sheet(PLANE, text=CASE.replace('edge = "u0"', 'edge = "u2"'))
    foam = 'material = { kind = "foam", loading = [[0, 0], [0.5, 0.1], [0.9, 1]] }'
    with pytest.raises(InputError, match="Foam is no material of shells"):
        sheet(PLANE, text=re.sub("material = .*", foam, CASE))
