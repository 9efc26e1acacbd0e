"""Impact grids: points on the exact surface, by their spacing or along wrap lines."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import CaseError, ContigaWarning, FileError, UnitError
from contiga.studies.maps import map_of
from contiga.studies.study import run_study
from contiga.studies.targets import TargetsSpec, targets_of

from .conftest import base_in, study_from

BALL = cg.Body([cg.shapes.sphere(radius=10.0)])


def at(rows: list[dict[str, float]]) -> np.ndarray:
    return np.array([[row[axis] for axis in "xyz"] for row in rows])


def test_a_grid_stands_on_the_surface_above_multiples_of_its_spacing() -> None:
    points = at(targets_of(TargetsSpec(body="ball", spacing=3.0), BALL, np.eye(4), "mm"))
    assert (points[:, :2] / 3.0 == np.round(points[:, :2] / 3.0)).all()
    np.testing.assert_allclose(points[:, 2], np.sqrt(100.0 - (points[:, :2] ** 2).sum(axis=1)))
    inside = [(i, j) for i in range(-3, 4) for j in range(-3, 4) if 9 * (i * i + j * j) < 100.0]
    assert len(points) == len(inside)


def test_a_grid_follows_its_direction_and_origin() -> None:
    spec = TargetsSpec(
        body="ball", spacing=4.0, direction=[1.0, 0.0, 1.0], across=[1.0, 1.0, 0.0],
        origin=[0.0, 1.0, 7.0],
    )  # fmt: skip
    points = at(targets_of(spec, BALL, np.eye(4), "mm"))
    down = np.array([1.0, 0.0, 1.0]) / math.sqrt(2.0)
    across = np.array([0.5, 1.0, -0.5]) / math.sqrt(1.5)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 10.0)
    assert (points @ down < 0.0).all()
    steps = (points - [0.0, 1.0, 7.0]) @ across / 4.0
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    turned = (points - [0.0, 1.0, 7.0]) @ np.cross(down, across) / 4.0
    np.testing.assert_allclose(turned, np.round(turned), atol=1e-9)


def lines_in(folder: Path, text: str) -> TargetsSpec:
    path = folder / "wad.csv"
    path.write_text(text, encoding="utf-8")
    spec = {"body": "ball", "spacing": 2.0, "lines": "wad.csv"}
    return TargetsSpec.model_validate(spec, context={"folder": folder})


def test_points_of_wrap_lines_are_apart_from_side_to_side(tmp_path: Path) -> None:
    text = (
        "line,x [mm],y [mm],z [mm]\n1000,0,-5,9\n1000,2,0,9\n1000,0,5,9\n1500,3,3,8\n1500,3,-1,8\n"
    )
    rows = targets_of(lines_in(tmp_path, text), BALL, np.eye(4), "mm")
    assert [row["line"] for row in rows] == 5 * [1000] + 2 * [1500]
    assert [row["y"] for row in rows] == pytest.approx([-4, -2, 0, 2, 4, 2, 0], abs=1e-9)
    assert [row["x"] for row in rows] == pytest.approx([0.4, 1.2, 2, 1.2, 0.4, 3, 3], abs=1e-9)
    np.testing.assert_allclose(np.linalg.norm(at(rows), axis=1), 10.0)


def test_points_of_wrap_lines_are_in_the_units_of_their_heads(tmp_path: Path) -> None:
    plain = lines_in(tmp_path, "line,x,y,z\n7,0,-5,9\n7,2,5,9\n")
    wanted = targets_of(plain, BALL, np.eye(4), "mm")
    text = '"line";"x [cm]";"y [mm]";"z"\n7;0;-5,0;9\n7;0,2;5;9\n'
    assert targets_of(lines_in(tmp_path, text), BALL, np.eye(4), "mm") == wanted


@pytest.mark.parametrize(
    ("ys", "spacing", "expected"),
    [
        ([-4, 4], 2.0, [-4, -2, 0, 2, 4]),
        ([4, -4], 2.0, [4, 2, 0, -2, -4]),
        ([-4, 0, 4], 2.0, [-4, -2, 0, 2, 4]),
        ([0, 0.3], 0.1, [0, 0.1, 0.2, 0.3]),  # 0.3 / 0.1 is a little less than 3
        ([0.3, 0], 0.1, [0.3, 0.2, 0.1, 0]),
    ],
)
def test_both_ends_of_a_line_count(
    tmp_path: Path, ys: list[float], spacing: float, expected: list[float]
) -> None:
    text = "line,x,y,z\n" + "".join(f"1,0,{y},9\n" for y in ys)
    spec = lines_in(tmp_path, text).model_copy(update={"spacing": spacing})
    rows = targets_of(spec, BALL, np.eye(4), "mm")
    assert [row["y"] for row in rows] == pytest.approx(expected, abs=1e-12)


def test_lines_between_multiples_say_that_no_ray_meets(tmp_path: Path) -> None:
    spec = lines_in(tmp_path, "line,x,y,z\n1,0,0.5,9\n1,0,1.5,9\n")
    with pytest.raises(CaseError, match=r"no ray meets.*found '0 rays"):
        targets_of(spec, BALL, np.eye(4), "mm")


def test_so_many_points_of_lines_are_refused_before_they_are_made(tmp_path: Path) -> None:
    spec = lines_in(tmp_path, "line,x,y,z\n1,0,0,9\n1,0,5,9\n1,0,0,9\n")
    for spacing in (9e-6, 1e-300, 5e-324):
        with pytest.raises(CaseError, match="too many targets"):
            targets_of(spec.model_copy(update={"spacing": spacing}), BALL, np.eye(4), "mm")


def test_targets_stand_where_the_body_is_at_the_start() -> None:
    """A sphere off its origin, turned and moved: the same grid as over it where it then is."""
    ball = cg.Body([cg.shapes.sphere(radius=10.0, centre=(30.0, 0.0, 0.0))])
    pose = np.array([[0.0, -1, 0, 5], [1, 0, 0, -30], [0, 0, 1, 7], [0, 0, 0, 1]])
    points = at(targets_of(TargetsSpec(body="ball", spacing=3.0), ball, pose, "mm"))
    assert (points[:, :2] / 3.0 == np.round(points[:, :2] / 3.0)).all()
    np.testing.assert_allclose(np.linalg.norm(points - [5.0, 0.0, 7.0], axis=1), 10.0)
    assert (points[:, 2] > 7.0).all()
    assert len(points) > 20


def test_rays_that_were_given_up_are_told_and_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = TargetsSpec(body="ball", spacing=3.0)
    count = len(targets_of(spec, BALL, np.eye(4), "mm"))
    search = cg.Body.first_hit

    def tired(self: cg.Body, p0: np.ndarray, p1: np.ndarray) -> cg.Hit:
        hit = search(self, p0, p1)
        hit.status[np.flatnonzero(hit.status == cg.Status.OK)[:2]] = cg.Status.BUDGET
        return hit

    monkeypatch.setattr(cg.Body, "first_hit", tired)
    with pytest.warns(ContigaWarning, match="search of 2 rays was given up"):
        rows = targets_of(spec, BALL, np.eye(4), "mm")
    assert len(rows) == count - 2


@pytest.mark.parametrize("size", [1e-12, 1e6])
def test_targets_do_not_know_the_unit_of_length(size: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=10.0 * size)])
    spec = TargetsSpec(body="ball", spacing=3.0 * size)
    points = at(targets_of(spec, ball, np.eye(4), "mm"))
    one = at(targets_of(TargetsSpec(body="ball", spacing=3.0), BALL, np.eye(4), "mm"))
    np.testing.assert_allclose(points / size, one, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("line,x,y,z\n", "has no rows"),
        ("line,x,y\n1,0,0\n", "column 'z' is missing"),
        ("line,x [kg],y,z\n1,0,0,0\n1,0,1,0\n", r"wad.csv:1: x \[kg\]: not a unit of length"),
        ("line,x,y,z\n1,0,0,0\n", "one point only"),
        ("line,x,y,z\n1,0,0,zero\n", "a number for line, x, y and z"),
    ],
)
def test_tables_of_lines_that_say_nothing_are_refused(
    tmp_path: Path, text: str, words: str
) -> None:
    with pytest.raises((FileError, UnitError), match=words):
        targets_of(lines_in(tmp_path, text), BALL, np.eye(4), "mm")


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({"spacing": 1e-3}, "too many targets"),
        ({"spacing": 5e-324}, "too many targets"),
        ({"spacing": 5e-324, "origin": [90.0, 90.0, 0.0]}, "too many targets"),
        ({"spacing": 99.0, "origin": [40.0, 0.0, 0.0]}, "no ray meets"),
        ({"spacing": 2.0, "across": [0.0, 0.0, 1.0]}, "not be parallel to direction"),
        ({"spacing": 2.0, "direction": [0.0, 0.0, 0.0]}, "not be parallel to direction"),
    ],
)
def test_grids_without_points_are_refused(said: dict[str, object], words: str) -> None:
    with pytest.raises(CaseError, match=words):
        targets_of(TargetsSpec(body="ball", **said), BALL, np.eye(4), "mm")


TEXT = """
base = "case.toml"
collect = ["max(force)"]
targets = { body = "ball", spacing = 6.0, direction = [0, 0, 1] }
[set]
"time.end" = 0.5
[[rule]]
require = "y >= 0"
[[rule]]
key = "body.ball.motion.velocity[0]"
value = "0.001 * x + 0 * z"
""" + "".join(f'[[variable]]\nname = "{a}"\ncolumn = "{a}"\n' for a in "xyz")


def test_a_study_has_a_case_for_each_target(folder: Path) -> None:
    actual = run_study(study_from(TEXT, folder), folder / "out", workers=0)
    assert len(actual.rows) == 6
    for row in actual.rows:
        x, y, z = (row.values[axis] for axis in "xyz")
        assert math.hypot(x, y, z - 10.5) == pytest.approx(10.0)
        assert z < 10.5
        assert y > -1e-9


def test_a_study_finds_its_targets_where_a_motion_puts_the_body(folder: Path) -> None:
    """A motion begins 41 mm to the side: targets and what the map draws are there."""
    case, free = folder / "case.toml", 'kind = "free", velocity = [0, 0, -1.0]'
    text = case.read_text(encoding="utf-8")
    assert free in text
    text = text.replace(free, 'kind = "translate", table = [[0, 41, 0, 0], [2, 41, 0, -1]]')
    case.write_text(text, encoding="utf-8")
    aside = TEXT.replace("body.ball.motion.velocity[0]", "slave.sheet.thickness")
    aside = aside.replace('"0.001 * x + 0 * z"', '"1 + 0 * (x + z)"')
    study = study_from('map = { body = "ball", at = ["x", "y", "z"] }' + aside, folder)
    actual = run_study(study, folder / "out", workers=0)
    assert len(actual.rows) == 6
    for row in actual.rows:
        x, y, z = (row.values[axis] for axis in "xyz")
        assert math.hypot(x - 41.0, y, z - 10.5) == pytest.approx(10.0)
    drawn = map_of(study, base_in(folder)._replace(text=text), actual.rows)
    assert drawn is not None
    np.testing.assert_allclose(drawn.vertices.mean(axis=0), [41.0, 0.0, 10.5], atol=1.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('body = "ball", sp', 'body = "bal", sp', r"targets\.body.*no such body.*ball"),
        ('column = "x"', 'column = "line"', "no such column.*line.*x, y, z"),
        ("spacing = 6.0", "spacing = 0", r"targets\.spacing.*too small"),
        ("[set]", 'table = "case.toml"\n[set]', "one of the two"),
        ("spacing = 6.0", "spacing = 600.0, origin = [40, 0, 0]", r"study\.toml: targets: no ray"),
    ],
)
def test_wrong_targets_are_one_message(folder: Path, old: str, new: str, words: str) -> None:
    assert old in TEXT
    with pytest.raises(CaseError, match=words):
        run_study(study_from(TEXT.replace(old, new), folder), folder / "out", workers=0)
    assert not (folder / "out").exists()
