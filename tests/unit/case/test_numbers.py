"""Whatever key has a number: text and truths are refused as what they are, none is converted."""

from __future__ import annotations

import copy
import inspect
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from contiga.case.geometry_spec import shape_catalogue
from contiga.case.problems import case_error
from contiga.case.schema import Case
from contiga.errors import GeometryError
from contiga.geometry import shapes
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.surface import NurbsSurface

CASE = """
title = "Every sort of number"
units = { length = "mm", mass = "kg", time = "ms" }
time = { start = 0.0, end = 13.0, step = "auto", safety = 0.8, largest = 0.1 }
world = { gravity = [0.0, 0.0, -9.81e-3] }
output = { every = 2 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 20.0, centre = [0, 0, 5], transform = [
  { translate = [0, 0, 1] }, { rotate = { degrees = 5, axis = [0, 1, 0] } }, { scale = 2 }] }
mass = { total = 4.5, centre = [0, 0, 5], inertia = [1, 1, 1, 0, 0, 0] }
motion = { kind = "free", velocity = [0, 0, -1], spin = [0, 0.1, 0] }
[[body]]
name = "sled"
geometry.profile.nurbs = { degree = 1, knots = [0, 0, 1, 1], control_points = [[0, 0], [1, 0]] }
geometry.depth = 10.0
motion = { kind = "acceleration", direction = [1, 0, 0], table = [[0, 0], [1, 2]] }
[[slave]]
name = "pad"
points.grid = { shape = "plane", width = 3, length = 4, nu = 5, nv = 6 }
points.box = [[-1, -1, -1], [1, 1, 1]]
points.side = { direction = [0, 0, 1], angle = 30 }
thickness = 9
mass = 0.1
[[slave]]
name = "cloud"
points = { coordinates = [[0, 0, 0], [1, 0, 0]] }
area = 2.0
[[contact]]
master = "ball"
slave = "pad"
law = { kind = "stress", elastic = [[0, 0], [0.5, 0.1]], damping = 0.1 }
friction = { kind = "coulomb", static = 0.4, dynamic = 0.3, decay = 1.0, stiffness = 0.0 }
[[contact]]
master = "sled"
slave = "cloud"
law = { kind = "penalty", stiffness = 3.0, damping = 0.1 }
area = { kind = "constant", value = 1.0 }
[[load]]
body = "ball"
force = [[0, 1, 0, 0], [5, 0, 0, 0]]
at = [0, 0, 5]
[[spring]]
between = ["ball", "ground"]
at = [[0, 0, 5], [0, 0, 100]]
length = 90.0
curve = [[-1, -1], [1, 1]]
damping = 0.2
"""
GOOD: dict[str, Any] = tomllib.loads(CASE)


def numbers(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Places of all numbers in tables and lists."""
    entries = value.items() if isinstance(value, dict) else enumerate(value)
    for key, entry in entries:
        if isinstance(entry, dict | list):
            yield from numbers(entry, (*path, key))
        elif isinstance(entry, int | float):
            yield (*path, key)


def message(case: dict[str, Any]) -> str:
    with pytest.raises(ValidationError) as caught:
        Case.model_validate(case, context={"folder": Path(), "units": case["units"]})
    return str(case_error(caught.value, case, "case.toml"))


@pytest.mark.parametrize("wrong", ["20", True])
def test_text_and_truths_are_no_numbers_anywhere(wrong: object) -> None:
    Case.model_validate(GOOD, context={"folder": Path(), "units": GOOD["units"]})
    places = list(numbers(GOOD))
    assert len(places) > 90
    for *outer, last in places:
        case = copy.deepcopy(GOOD)
        table: Any = case
        for key in outer:
            table = table[key]
        table[last] = wrong
        said = message(case)
        match = re.search(r"(\S+): must be (a |a whole |finite )numbers?\b.*found (.*)", said)
        assert match, (outer, last, said)
        assert str([key for key in (*outer, last) if isinstance(key, str)][-1]) in match[1]
        assert repr(wrong) in match[3]


@pytest.mark.parametrize("name", ["arc", *shape_catalogue(NurbsSurface)])
def test_no_argument_of_a_shape_is_read_from_text(name: str) -> None:
    made = NurbsCurve if name == "arc" else NurbsSurface
    shape = shape_catalogue(made)[name]
    for key, parameter in inspect.signature(shape).parameters.items():
        if parameter.annotation == "float" and name != "revolved":
            with pytest.raises(GeometryError, match=f"^{key}: must be a number; found '20'"):
                shape(**{key: "20"})
    with pytest.raises(GeometryError, match="angle: must be a number; found True"):
        shapes.revolved(shapes.line((1, 0, 0), (1, 0, 1)), True)
