"""A body called "ground", as a road is: allowed unless springs mean the world by it."""

from __future__ import annotations

from pathlib import Path

import pytest

import contiga as cg
from contiga.errors import CaseError, InputError

CASE = """
units = { length = "mm", mass = "kg", time = "ms" }
time = { end = 1.0, step = 0.05 }
[[body]]
name = "ground"
geometry = { shape = "plane", width = 300, length = 300 }
[[body]]
name = "head"
geometry = { shape = "sphere", radius = 50, centre = [0, 0, 50.5] }
mass = { total = 4.5 }
motion = { kind = "free", velocity = [0, 0, -2] }
[[slave]]
name = "skin"
points = { body = "head" }
[[contact]]
master = "ground"
slave = "skin"
law = { kind = "penalty", stiffness = 1e-3, per_area = true }
[[load]]
body = "ground"
force = [1, 0, 0]
[[sensor]]
name = "cell"
body = "ground"
measures = ["force"]
"""
SPRING = """
[[spring]]
between = ["head", "ground"]
at = [[0, 0, 50], [0, 0, 0]]
curve = 1.0
"""


def load(folder: Path, text: str) -> cg.Case:
    (folder / "case.toml").write_text(text, encoding="utf-8")
    return cg.load_case(folder / "case.toml")


def test_a_body_may_be_called_ground(tmp_path: Path) -> None:
    history = cg.run(load(tmp_path, CASE)).history
    assert history["n_contact"].max() > 0
    # What the contact does, and the load.
    assert history["cell.fx"][0] == 1.0
    assert history["cell.fz"].min() == pytest.approx(-history["force"].max())


def test_not_where_springs_mean_the_world_by_it(tmp_path: Path) -> None:
    said = r"body\[0\]\.name: means the world in spring\[0\]; found 'ground'"
    with pytest.raises(CaseError, match=said):
        load(tmp_path, CASE + SPRING)
    # A spring between others is in nobody's way.
    load(tmp_path, CASE + SPRING.replace('"ground"', '"wall"') + '[[body]]\nname = "wall"\n'
         'geometry = { shape = "plane" }\n')  # fmt: skip


def test_nor_in_python() -> None:
    ball = cg.Body(cg.shapes.sphere(radius=1.0))
    free = cg.motion.Free(ball.mass_properties(1.0))
    spring = cg.Spring(("ball", "ground"), at=[[0, 0, 0], [0, 0, 9]], curve=1.0)
    given = {"slaves": {}, "contacts": [], "springs": [spring], "end": 1.0, "step": 0.1}
    cg.Simulation(bodies={"ball": (ball, free)}, **given)
    with pytest.raises(InputError, match="spring 'ball-ground': between: means the world"):
        cg.Simulation(bodies={"ball": (ball, free), "ground": ball}, **given)
