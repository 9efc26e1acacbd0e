"""A base case that runs in a blink, and studies of it."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from contiga.studies.cases import StudyCase
from contiga.studies.one_case import Base
from contiga.studies.quantities import quantity_of
from contiga.studies.spec import StudySpec, study_of

CASE = """
title = "Ball on a sheet"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 2.0, step = 0.5 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0, centre = [0, 0, 10.5] }
mass = { total = 1000.0 }
motion = { kind = "free", velocity = [0, 0, -1.0] }
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "force", curve = [[0, 0], [1, 100]] }
[[sensor]]
name = "cg"
body = "ball"
criteria = ["HIC15"]
[output]
formats = ["csv"]
report = false
"""

STUDY = """
title = "Speeds and steps"
base = "case.toml"
collect = ["max(force)", "at(ball.vz, 2)", "cg.HIC15"]
[[variable]]
name = "speed"
key = "body.ball.motion.velocity[2]"
values = [-1.0, -2.0]
[[variable]]
name = "step"
key = "time.step"
values = [0.5, 0.25]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """With the base case and the study."""
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path


def study_from(text: str, folder: Path) -> StudySpec:
    """The study of a text in a folder."""
    return study_of(tomllib.loads(text), folder / "study.toml")


def base_in(folder: Path, *quantities: str) -> Base:
    """What cases of the base case have in common, in the folder ``out``."""
    values = {text: quantity_of(text) for text in quantities or ("max(force)",)}
    return Base(CASE, str(folder / "case.toml"), str(folder / "out"), values)


def case_at(number: int, speed: float, **settings: object) -> StudyCase:
    """A case of the ball at a speed."""
    key = "body.ball.motion.velocity[2]"
    return StudyCase(number, {"speed": speed}, {key: speed, **settings})
