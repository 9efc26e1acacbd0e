"""Bodies of a case that change their shape."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.case.build import build
from contiga.errors import ContigaError

CASE = """
title = "a plate that rises"
[units]
length = "mm"
mass = "g"
time = "ms"
[time]
end = 1.0
step = {step}
[[body]]
name = "plate"
geometry = {{ shape = "plane", width = 4.0, length = 4.0 }}
motion = {{ kind = "deform"{motion} }}
[[slave]]
name = "point"
points = {{ coordinates = [[0.0, 0.0, 0.5]] }}
area = 1.0
thickness = 0.2
[[contact]]
master = "plate"
slave = "point"
{thickness}
law = {{ kind = "penalty", stiffness = 10.0 }}
"""
REST = np.array([[-2.0, -2.0, 0.0], [-2.0, 2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0]])


def rows(*heights: float) -> str:
    shapes = [REST + np.array([0.0, 0.0, h]) for h in heights]
    return str([[float(t), *shape.ravel().tolist()] for t, shape in enumerate(shapes)])


def simulation_of(folder: Path, motion: str, **options: Any) -> cg.Simulation:
    case = folder / "case.toml"
    how = {"step": "0.05", "thickness": "shell_thickness = true"} | options
    case.write_text(CASE.format(motion=f", {motion}" if motion else "", **how), encoding="utf-8")
    return build(cg.load_case(case))


@pytest.mark.parametrize("kind", ["table", "file"])
def test_a_table_or_a_file_moves_the_control_points(tmp_path: Path, kind: str) -> None:
    motion = f"table = {rows(0.0, 0.45)}"
    if kind == "file":
        np.savez(
            tmp_path / "shape.npz",
            times=[0.0, 1.0],
            control_points=[REST, REST + np.array([0.0, 0.0, 0.45])],
        )
        motion = 'file = "shape.npz"'
    simulation = simulation_of(tmp_path, motion)
    state = simulation.start()
    while state.time < 1.0 - 1e-9:
        state = simulation.step(state)
    (contact,) = state.contacts.values()
    assert contact.max_penetration == pytest.approx(0.05, abs=1e-12)
    np.testing.assert_allclose(contact.control_force.sum(axis=0), [0.0, 0.0, -0.5], atol=1e-12)


@pytest.mark.parametrize(
    ("motion", "options", "told"),
    [
        ("", {}, "exactly one of the keys file or table"),
        (f"table = {rows(0.0, 0.1)}, file = 'case.toml'", {}, "exactly one of the keys"),
        ("table = [[0.0, 1.0, 2.0]]", {}, r"motion.table.*1 \+ 3 m numbers a row"),
        ("table = [[0.0, 0.0, 0.0, 0.0]]", {}, "one row a control point of the body"),
        (f"table = {rows(0.0)[:-1]}, {rows(0.0)[1:]}", {}, "times go back or repeat"),
        ("file = 'case.toml'", {}, "cannot be read"),
        (f"table = {rows(0.0)}", {"thickness": 'foot = "tracked"'}, "feet are not followed"),
    ],
)
def test_what_is_wrong_is_told_in_one_message(
    tmp_path: Path, motion: str, options: dict[str, Any], told: str
) -> None:
    with pytest.raises(ContigaError, match=told):
        simulation_of(tmp_path, motion, **options)


@pytest.mark.parametrize(
    ("times", "points", "told"),
    [
        ([0.0, 1.0], np.zeros((2, 5, 3)), r"found \(5, 3\).*allowed: \(4, 3\)"),
        ([0.0, 1.0], np.zeros((2, 4, 2)), "must be control points at each time"),
        ([0.0, 1.0, 2.0], [REST, REST], "one finite time for each row"),
        ([1.0, 0.0], [REST, REST], "times go back or repeat at row 1"),
        (["a", "b"], [REST, REST], "'times' must hold numbers"),
        ([0.0, 1.0], [REST, np.nan * REST], "must be finite"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_in_one_message(
    tmp_path: Path, times: Any, points: Any, told: str
) -> None:
    np.savez(tmp_path / "shape.npz", times=times, control_points=points)
    with pytest.raises(ContigaError, match=told):
        simulation_of(tmp_path, "file = 'shape.npz'")


def test_a_closed_solid_changes_its_shape_with_a_thickness_and_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ball = 'geometry = {{ shape = "sphere", radius = 1.0 }}'
    flat = 'geometry = {{ shape = "plane", width = 4.0, length = 4.0 }}'
    monkeypatch.setitem(globals(), "CASE", CASE.replace(flat, ball))
    rest = cg.Body([cg.shapes.sphere(radius=1.0)]).net.points
    np.savez(tmp_path / "shape.npz", times=[0.0, 1.0], control_points=[rest, 1.1 * rest])
    for options in ({}, {"thickness": ""}):
        assert simulation_of(tmp_path, "file = 'shape.npz'", **options).shapes.of
