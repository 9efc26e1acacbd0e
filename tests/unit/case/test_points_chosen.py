"""`box`, `side`, `sets` and `layer` of a case's points."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

import contiga as cg
from contiga.case.build import build
from contiga.case.describe import description
from contiga.errors import InputError

CASE = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 1.0, step = 0.5 }}
[[body]]
name = "ball"
geometry = {{ shape = "sphere", radius = 1.0, centre = [0, 0, 50] }}
[[body]]
name = "anvil"
geometry = {{ shape = "sphere", radius = 5.0 }}
[[slave]]
name = "pad"
points = {{ {points} }}
[[contact]]
master = "ball"
slave = "pad"
law = {{ kind = "penalty", stiffness = 1.0 }}
"""
GRID = 'grid = { shape = "plane", width = 10, length = 10, nu = 11, nv = 11 }'
CUBE = 'file = "cube.vtu", unit = "cm"'


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    meshio.write(
        tmp_path / "cube.vtu", meshio.Mesh(corners, [("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])])
    )
    return tmp_path


def load(folder: Path, points: str) -> cg.Case:
    path = folder / "case.toml"
    path.write_text(CASE.format(points=points), encoding="utf-8")
    return cg.load_case(path)


@pytest.mark.parametrize(
    ("points", "bounds", "said"),
    [
        (f"{GRID}, box = [[0, -9, -1], [2, 9, 1]]", [[0, -5, 0], [2, 5, 0]], "in the box"),
        (  # where it is placed, in the unit of the case
            f"{GRID}, transform = [{{ translate = [100, 0, 0] }}], "
            "box = [[99, -9, 0], [101, 9, 0]]",
            [[99, -5, 0], [101, 5, 0]], "in the box",
        ),
        (f"{CUBE}, side = {{ direction = [0, 0, 1] }}", [[0, 0, 10], [10, 10, 10]],
         "within 60° of [0.0, 0.0, 1.0]"),
        (f"{CUBE}, side = {{ direction = [1, 0, 0], angle = 5 }}", [[10, 0, 0], [10, 10, 10]],
         "within 5°"),
        (f'{CUBE}, layer = "all"', [[0, 0, 0], [10, 10, 10]], "layer all"),
        (f"{CUBE}, layer = 1", [[0, 0, 0], [10, 10, 10]], "layer 1"),
        ('body = "anvil", side = { direction = [0, 0, -1], angle = 80 }', None, "within 80°"),
    ],
)  # fmt: skip
def test_what_takes_part_is_chosen(
    folder: Path, points: str, bounds: list[list[float]] | None, said: str
) -> None:
    case = load(folder, points)
    assert said in description(case)
    slave = build(case).slaves["pad"].slave
    if bounds is None:
        assert slave.bounds()[1, 2] < 0.0
    else:
        assert np.allclose(slave.bounds(), bounds)
    assert slave.active.sum() < len(slave) or "layer" in points


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (f"{GRID}, box = [[0, 0, 0]]", r"slave\[0\]\.points\.box"),
        (f"{GRID}, box = [[50, 0, 0], [60, 9, 9]]",
         r"slave\[0\]\.points.*box: no point lies in the box"),
        (f"{GRID}, side = {{ angle = 5 }}", r"points\.side\.direction"),
        (f"{GRID}, side = {{ direction = [0, 0, 1], angle = 200 }}", r"points\.side\.angle"),
        (f"{GRID}, side = {{ direction = [0, 0, 0] }}", "a direction is three numbers"),
        (f'{CUBE}, layer = "core"', r"points\.layer"),
        (f"{CUBE}, layer = 0", r"points\.layer"),
        (f"{CUBE}, layer = 2", r"slave\[0\]\.points.*no such layer.*allowed: 1 to 1"),
        (f'{CUBE}, sets = ["top"]', "nothing: the file names no parts"),
        (f"{CUBE}, boks = [[0, 0, 0], [1, 1, 1]]", r"unknown key"),
    ],
)  # fmt: skip
def test_what_chooses_nothing_is_one_message(folder: Path, points: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build(load(folder, points))
