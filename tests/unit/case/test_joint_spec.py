"""The `joint` tables of a case: what they make, how they are said, and what is wrong with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.case.columns import columns_of_case
from contiga.case.describe import describe
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError, InputError
from contiga.report.joints import joint_table
from contiga.report.run_folder import read_run

CASE = """
[units]
length = "m"
mass = "kg"
time = "s"
[time]
end = 0.1
step = 2e-3
[world]
gravity = [0, 0, -9.81]

[[body]]
name = "thigh"
geometry = { shape = "sphere", radius = 0.2, centre = [0, 0, -0.5] }
mass = { total = 8.0 }
motion = { kind = "free" }

[[body]]
name = "shin"
geometry = { shape = "sphere", radius = 0.15, centre = [0.3, 0, -1.0] }
mass = { total = 4.0 }
motion = { kind = "free" }

[[joint]]
name = "hip"
kind = "spherical"
between = ["ground", "thigh"]
at = [0, 0, 0]
axis = [0, 0, -1]
cone = { curve = [[0, 0], [1, 40]], damping = 0.5 }

[[joint]]
name = "knee"
kind = "revolute"
between = ["thigh", "shin"]
at = [0, 0, -0.8]
axis = [0, 1, 0]

[joint.angle]
stops = [-2.4, 0.0]
stop_curve = 500.0
start = -0.4
friction = 1.0
friction_slope = 100.0

[output]
report = false
"""


def case_of(folder: Path, old: str = "", new: str = "") -> cg.Case:
    assert CASE.count(old) == 1 or not old
    file = folder / "case.toml"
    file.write_text(CASE.replace(old, new) if old else CASE)
    return cg.load_case(file)


def test_a_case_makes_the_joints_that_it_names(tmp_path: Path) -> None:
    hip, knee = cg.build(case_of(tmp_path)).joints.values()
    assert (hip.kind, hip.between, hip.name) == ("spherical", ("ground", "thigh"), "hip")
    assert (knee.kind, knee.between) == ("revolute", ("thigh", "shin"))
    np.testing.assert_array_equal(knee.at, [[0, 0, -0.8]] * 2)
    np.testing.assert_array_equal(knee.axis, [[0, 1, 0]] * 2)
    law = knee.laws["angle"]
    assert (law.stops, law.start, law.friction, law.friction_slope) == (
        (-2.4, 0.0),
        -0.4,
        1.0,
        100.0,
    )
    assert law.stop_curve is not None
    assert law.stop_curve(2.0) == 1000.0
    assert hip.laws["cone"].damping == 0.5


def test_a_joint_without_a_name_is_called_by_its_bodies(tmp_path: Path) -> None:
    case = case_of(tmp_path, 'name = "knee"\n', "")
    assert list(cg.build(case).joints) == ["hip", "thigh-shin"]


def test_the_resolved_case_is_the_same_case_and_is_said_in_words(tmp_path: Path) -> None:
    case = case_of(tmp_path)
    copy = tmp_path / "copy.toml"
    copy.write_text(resolved_toml(case))
    assert resolved_toml(cg.load_case(copy)) == resolved_toml(case)
    said = dict(describe(case))
    assert said["joint knee"] == (
        "revolute between thigh and shin; angle: from -0.4, stop curve 2 points from x = 0 to "
        "(1, 500), goes on straight beyond, friction 1, stops at -2.4 and 0"
    )
    assert said["joint hip"].startswith("spherical between ground and thigh; cone: curve 2 points")


def test_a_run_has_the_columns_that_a_case_foretells_and_its_report_a_table(tmp_path: Path) -> None:
    case = case_of(tmp_path)
    result = cg.build(case).run(tmp_path / "out")
    mine = {"hip", "knee"}
    told = [name for name in result.history if name.rpartition(".")[0] in mine]
    foretold = [name for name in columns_of_case(case) if name.rpartition(".")[0] in mine]
    assert sorted(told) == sorted(foretold)
    assert result.history["knee.angle"][0] == pytest.approx(-0.4)
    units = result.summary["columns"]
    assert [units[f"knee.{name}"] for name in ("angle", "fx", "my", "angle_force")] == [
        *("rad", "N"),
        *(units["knee.mx"], units["knee.mx"]),
    ]
    assert units["knee.angle_energy_friction"] == "J"
    knee = result.summary["joints"]["knee"]
    assert (knee["kind"], knee["between"]) == ("revolute", ["thigh", "shin"])
    assert np.shape(knee["lines"]) == (1, 2, 3)
    table = joint_table(read_run(tmp_path / "out"))
    assert "thigh – shin" in table
    assert "revolute" in table
    assert "angle -2" in table  # degrees


def test_a_study_may_set_what_stands_in_a_joint(tmp_path: Path) -> None:
    case_of(tmp_path)
    case = cg.load_case(tmp_path / "case.toml", set={"joint.knee.angle.friction": 3.0})
    assert cg.build(case).joints["knee"].laws["angle"].friction == 3.0


@pytest.mark.parametrize(
    ("old", "new", "where", "what"),
    [
        ('["thigh", "shin"]', '["thigh", "shn"]', "joint[1].between[1]", "no body of this name"),
        ('["thigh", "shin"]', '["thigh"]', "joint[1].between", "must be two names"),
        ("axis = [0, 1, 0]", "axis = [0, 0, 0]", "joint[1].axis", "has no length"),
        ("axis = [0, 1, 0]", "axis = [0, 1]", "joint[1].axis", "must be a vector"),
        ("start = -0.4", "start = 0.25", "joint[1].angle.stops", "0.25 beyond its stop"),
        ('kind = "revolute"', 'kind = "revolut"', "joint[1].kind", "revolute"),
        ('kind = "revolute"', 'kind = "weld"', "joint[1].angle", "does not have this"),
        ("friction_slope = 100.0", "slope = 1.0", "joint[1].angle.slope", "unknown key"),
        ('name = "knee"', 'name = "hip"', "joint[1].name", "used 2 times"),
        ('name = "shin"', 'name = "ground"', "body[1].name", "means the world in joint[0]"),
    ],
)
def test_what_is_wrong_with_a_joint_is_told_by_its_key(
    tmp_path: Path, old: str, new: str, where: str, what: str
) -> None:
    with pytest.raises(CaseError) as told:
        case_of(tmp_path, old, new)
    assert where in str(told.value)
    assert what in str(told.value)
    assert "joint[0]" not in str(told.value) or what.endswith("joint[0]")  # and of nothing else


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        (
            "at = [0, 0, 0]\n",
            "at = [[0, 0, 0], [0, 0, 0.1]]\n",
            None,  # closed by moving the bodies
        ),
        (
            '[[joint]]\nname = "knee"',
            '[[joint]]\nname = "a"\nkind = "weld"\nbetween = ["thigh", "shin"]\nat = [0, 0, 0]\n'
            '[[joint]]\nname = "b"\nkind = "weld"\nbetween = ["thigh", "shin"]\n'
            'at = [[0, 0, 0], [0, 0, 0.1]]\n[[joint]]\nname = "knee"',
            "contradict each other",
        ),
    ],
)
def test_joints_that_do_not_close_are_told_once_when_the_case_is_built(
    tmp_path: Path, old: str, new: str, what: str | None
) -> None:
    case = case_of(tmp_path, old, new)
    if what is None:
        assert cg.build(case).joint_fit.moved.max() > 0.01
        return
    with pytest.raises(InputError, match=what):
        cg.build(case)
