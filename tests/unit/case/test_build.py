"""Cases become simulations: files are read, units converted, what is missing is told by its key."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.area.nodal import NodalArea
from contiga.case.build import build
from contiga.case.schema import parse_case
from contiga.errors import CaseError, FileError, InputError

CASE = """\
title = "pad"
[units]
length = "mm"
mass = "kg"
time = "ms"
[time]
end = 4
step = 1
[[body]]
name = "plate"
geometry = { shape = "plane", width = 2.0 }
reference_point = [0, 0, 1]
motion = { kind = "rotate", table = [[0, 0], [4, 90]] }
[[slave]]
name = "pad"
points = { coordinates = [[0, 0, 1], [1, 0, 1]] }
motion = { kind = "translate", table = [[0, 0, 0, 0], [4, 0, 0, -2]] }
[[contact]]
master = "plate"
slave = "pad"
law = { kind = "force", curve = 2 }
area = { kind = "constant", value = 0.5 }
"""
POINTS = "points = { coordinates = [[0, 0, 1], [1, 0, 1]] }"
MOTION = 'motion = { kind = "translate", table = [[0, 0, 0, 0], [4, 0, 0, -2]] }'
LAW = 'law = { kind = "force", curve = 2 }'
AREA = 'area = { kind = "constant", value = 0.5 }\n'


def built(folder: Path = Path(), **swaps: str):
    text = CASE
    for old, new in swaps.items():
        assert globals()[old] in text
        text = text.replace(globals()[old], new)
    return build(parse_case(text, folder / "case.toml"))


def test_a_simulation_has_what_the_case_says() -> None:
    simulation = built()
    assert simulation.title == "pad"
    np.testing.assert_array_equal(simulation.stepping.planned(), [0, 1, 2, 3, 4])
    plate, pad = simulation.bodies["plate"], simulation.slaves["pad"]
    np.testing.assert_array_equal(plate.body.reference_point, [0, 0, 1])
    np.testing.assert_allclose(plate.motion.pose(4.0)[:2, :2], [[0, -1], [1, 0]], atol=1e-15)
    np.testing.assert_array_equal(pad.motion.points(2.0), [[0, 0, 0], [1, 0, 0]])
    assert pad.slave.name == "pad"
    contact = simulation.contacts[0]
    assert (contact.name, contact.master, contact.slave) == ("plate-pad", "plate", "pad")
    assert 'title = "pad"' in simulation.case_text


def test_the_case_overrides_nodal_values() -> None:
    slave = built(POINTS=POINTS + "\nthickness = 2\narea = 3\nmass = 4").slaves["pad"].slave
    np.testing.assert_array_equal(slave.thickness, [2, 2])
    np.testing.assert_array_equal(slave.area, [3, 3])
    np.testing.assert_array_equal(slave.mass, [4, 4])


def test_a_mesh_file_is_converted_and_keeps_its_place(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "cloud.csv", [[0, 0, 1], [1, 2, 3]], delimiter=",")
    points = 'points = { file = "cloud.csv", unit = "m", transform = [{ translate = [5, 0, 0] }] }'
    slave = built(tmp_path, POINTS=points).slaves["pad"].slave
    np.testing.assert_allclose(slave.points, [[5, 0, 1000], [1005, 2000, 3000]])
    assert slave.name == "pad"


@pytest.mark.parametrize(
    ("extra", "time", "expected"),
    [
        ("", 3.0, 1.5),
        (", step = 1.0", 1.5, 1.5),
        (", times = [1, 2, 4]", 3.0, 1.5),
        (", times = [1, 2, 4]", 0.0, 0.0),
        (', unit = "cm"', 3.0, 15.0),
        (', then = { kind = "translate", table = [[0, 0, 0, 7]] }', 3.0, 8.5),
    ],
)
def test_a_series_moves_the_points(tmp_path: Path, extra: str, time: float, expected) -> None:
    for i, height in ((2, 0.0), (10, 1.0), (11, 2.0)):
        np.savetxt(tmp_path / f"p_{i}.csv", [[0, 0, height], [1, 0, height]], delimiter=",")
    motion = f'motion = {{ kind = "series", files = "p_*.csv"{extra} }}'
    points = built(tmp_path, MOTION=motion).slaves["pad"].motion.points(time)
    np.testing.assert_allclose(points[:, 2], expected)


@pytest.mark.parametrize(
    ("swaps", "kind", "message"),
    [
        ({"AREA": ""}, CaseError, r"contact\[0\]\.area: the points of 'pad' have no facets"),
        (
            {"AREA": 'area = { kind = "tributary" }\n'},
            CaseError,
            r"contact\[0\]\.area: .*found 'tributary'; allowed: \{ kind = \"constant\"",
        ),
        (
            {"LAW": 'law = { kind = "adaptive" }'},
            CaseError,
            r"contact\[0\]\.law: the law needs the slave's nodal mass",
        ),
        (
            {"LAW": 'law = { kind = "stress", elastic = 1 }'},
            CaseError,
            r"contact\[0\]\.law: the law needs the slave's nodal thickness",
        ),
        (
            {"POINTS": 'points = { file = "empty.vtu" }'},
            FileError,
            r"slave\[0\]\.points: .*empty\.vtu",
        ),
        (
            {"POINTS": 'points = { file = "nan.csv" }'},
            InputError,
            r"slave\[0\]\.points: .*not finite",
        ),
        (
            {"MOTION": 'motion = { kind = "series", files = "three.csv" }'},
            CaseError,
            r"slave\[0\]\.motion\.files: .*found '3 points'; allowed: 2",
        ),
        (
            {"MOTION": 'motion = { kind = "series", files = "three.csv", times = [1, 2] }'},
            InputError,
            r"slave\[0\]\.motion.*one time a file",
        ),
    ],
)
def test_what_does_not_fit_is_told_by_its_key(tmp_path: Path, swaps, kind, message) -> None:
    (tmp_path / "empty.vtu").write_text("")
    (tmp_path / "nan.csv").write_text("0,0,nan\n")
    np.savetxt(tmp_path / "three.csv", np.eye(3), delimiter=",")
    with pytest.raises(kind, match=message) as caught:
        built(tmp_path, **swaps)
    assert str(caught.value).startswith(f"{tmp_path / 'case.toml'}: ")
    assert caught.value.exit_code == 2


def test_a_nodal_area_of_the_slave_is_enough() -> None:
    contact = built(AREA="", POINTS=POINTS + "\narea = 3").contacts[0].contact
    assert isinstance(contact.area, NodalArea)
