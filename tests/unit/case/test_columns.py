"""The columns a case will have are those its run has."""

from __future__ import annotations

import pytest

import contiga as cg
from contiga.case.columns import columns_of_case, criteria_of_case
from contiga.case.schema import parse_case

HEAD = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.2, step = 0.01 }
[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 10.0, centre = [0, 0, 10.01] }
mass = { total = 1000.0 }
motion = MOTION
[[slave]]
name = "sheet"
points = { grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 } }
[[contact]]
master = "ball"
slave = "sheet"
law = { kind = "force", curve = [[0, 0], [1, 100]] }
"""
FREE = '{ kind = "free", velocity = [0, 0, -1] }'
GIVEN = '{ kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -1]] }'
FRICTION = "friction = { kind = 'coulomb', static = 0.3 }\n"
SECOND = """[[contact]]
name = "again"
master = "ball"
slave = "sheet"
law = { kind = "force", curve = [[0, 0], [1, 100]] }
"""
SENSORS = """[[sensor]]
name = "all"
body = "ball"
measures = ["acceleration", "velocity", "displacement", "force", "moment"]
filter = "CFC1000"
criteria = ["HIC15", "3ms"]
"""
SPRING = """[[spring]]
between = ["ball", "ground"]
at = [[0, 0, 0], [0, 0, 90]]
curve = [[0, 0], [1, 1]]
"""


@pytest.mark.parametrize(
    ("motion", "more"),
    [
        (FREE, ""),
        (GIVEN, ""),
        (FREE, FRICTION + SENSORS),
        (FREE, FRICTION + SECOND),
        (GIVEN, SECOND + SENSORS),
        (GIVEN, SPRING),
    ],
)
def test_columns_are_those_of_the_run(motion: str, more: str) -> None:
    case = parse_case(HEAD.replace("MOTION", motion) + more)
    told = columns_of_case(case)
    assert len(set(told)) == len(told)
    if len(case.contact) == 1:
        told = [name for name in told if not name.startswith("ball-sheet.")]
    history = cg.run(case).history
    assert sorted(told) == sorted(set(history) - {"time"})


def test_criteria_are_those_of_the_summary() -> None:
    case = parse_case(HEAD.replace("MOTION", FREE).replace("end = 0.2", "end = 4.0") + SENSORS)
    summary = cg.run(case).summary
    told = [f"{s}.{name}" for s, of in summary["sensors"].items() for name in of["criteria"]]
    assert criteria_of_case(case) == told == ["all.HIC15", "all.3ms"]
