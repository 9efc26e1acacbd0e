"""Sensors between two bodies, against closed forms of bodies that turn and fly."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg
from contiga.case.columns import columns_of_case
from contiga.errors import CaseError, InputError

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])
AXIS = np.array([1.0, 2.0, -2.0]) / 3.0
W, V = 0.9, np.array([0.3, -0.2, 0.5])


def flown(*sensors: cg.RelativeSensor, end: float = 4.0) -> dict[str, np.ndarray]:
    """Ball a flies off as V; ball b turns about `AXIS` through (5, 0, 0)."""
    free = {"inertia": np.eye(3), "mass": 1.0}
    return (
        cg.Simulation(
            bodies={
                "a": (BALL, cg.motion.Free(**free, velocity=V)),
                "b": (BALL, cg.motion.Free(**free, centre=(5, 0, 0), spin=W * AXIS)),
            },
            slaves={},
            contacts=[],
            sensors=sensors,
            end=end,
            step=0.05,
            units=("m", "kg", "s"),
        )
        .run()
        .history
    )


def test_distance_and_displacement_of_centres() -> None:
    told = flown(cg.RelativeSensor("ab", ("a", "b")), cg.RelativeSensor("ba", ("b", "a")))
    t = told["time"]
    way = np.array([5.0, 0, 0]) - np.outer(t, V)
    far = np.linalg.norm(way, axis=1)
    np.testing.assert_allclose(told["ab.distance"], far, rtol=1e-12)
    np.testing.assert_allclose(told["ab.rate"], -(way @ V) / far, rtol=1e-10)
    moved = np.stack([told[f"ab.{axis}"] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(moved, -np.outer(t, V), atol=1e-12)
    # Seen from the body that turns.
    turn = Rotation.from_rotvec(np.outer(t, W * AXIS))
    seen = turn.inv().apply(-way) + np.array([5.0, 0, 0])
    np.testing.assert_allclose(
        np.stack([told[f"ba.{axis}"] for axis in "xyz"], axis=1), seen, atol=1e-6
    )


def test_the_angle_goes_to_half_a_turn_and_back() -> None:
    told = flown(cg.RelativeSensor("ab", ("a", "b"), measures=["angle"]), end=6.0)
    turned = W * told["time"]
    expected = np.where(turned <= np.pi, turned, 2 * np.pi - turned)
    np.testing.assert_allclose(told["ab.angle"], expected, atol=1e-6)
    before = turned < 3.0
    axis = np.stack([told[f"ab.angle_{name}"] for name in "xyz"], axis=1)
    np.testing.assert_allclose(axis[before], np.outer(turned, AXIS)[before], atol=1e-6)
    assert "ab.distance" not in told


def test_points_off_the_centres_go_with_their_bodies() -> None:
    at = [[0.0, 0.5, 0.0], [5.0, 0.0, 0.8]]
    told = flown(cg.RelativeSensor("ab", ("a", "b"), at=at, axes="world"))
    turn = Rotation.from_rotvec(np.outer(told["time"], W * AXIS))
    ends = np.array([5.0, 0, 0]) + turn.apply([0.0, 0.0, 0.8])
    starts = np.array([0.0, 0.5, 0.0]) + np.outer(told["time"], V)
    np.testing.assert_allclose(
        told["ab.distance"], np.linalg.norm(ends - starts, axis=1), atol=1e-6
    )
    h = told["time"][1]
    slope = (told["ab.distance"][2:] - told["ab.distance"][:-2]) / (2 * h)
    np.testing.assert_allclose(told["ab.rate"][1:-1], slope, atol=2e-3)


def vectors(told: dict[str, np.ndarray], name: str) -> np.ndarray:
    return np.stack([told[name + axis] for axis in "xyz"], axis=1)


def test_axes_of_a_sensor_turn_with_its_first_body() -> None:
    own = np.array([[0.0, 0.6, 0.8], [1.0, 0.0, 0.0], [0.0, 0.8, -0.6]])
    measures = ["displacement", "angle", "velocity", "acceleration"]
    at = [[5.0, 0.0, 0.8], [0.0, 0.5, 0.0]]
    told = flown(
        cg.RelativeSensor("body", ("b", "a"), at=at, measures=measures),
        cg.RelativeSensor("own", ("b", "a"), at=at, measures=measures, axes=own),
        end=2.0,
    )
    for prefix in ("", "angle_", "v", "a"):
        body, mine = (vectors(told, f"{name}.{prefix}") for name in ("body", "own"))
        np.testing.assert_allclose(mine, body @ own.T, atol=1e-12)
        assert abs(body).max() > 0.1


def test_rates_are_those_that_one_on_the_first_body_sees() -> None:
    """From b, which turns as R about (5, 0, 0), a's centre is at R^T(V t - (5, 0, 0))."""
    rates = ["velocity", "acceleration"]
    told = flown(
        cg.RelativeSensor("ba", ("b", "a"), measures=rates),
        cg.RelativeSensor("ab", ("a", "b"), measures=rates),
        cg.RelativeSensor("flat", ("b", "a"), measures=rates, axes="world"),
    )
    t, spin = told["time"], W * AXIS
    back = Rotation.from_rotvec(np.outer(t, spin)).inv()
    way = np.outer(t, V) - np.array([5.0, 0, 0])
    v = V - np.cross(spin, way)
    a = -2.0 * np.cross(spin, v) - np.cross(spin, np.cross(spin, way))
    np.testing.assert_allclose(vectors(told, "ba.v"), back.apply(v), atol=1e-5)
    np.testing.assert_allclose(vectors(told, "ba.a"), back.apply(a), atol=1e-5)
    np.testing.assert_allclose(told["ba.v"], np.linalg.norm(v, axis=1), rtol=1e-6)
    np.testing.assert_allclose(told["ba.a"], np.linalg.norm(a, axis=1), rtol=1e-6)
    # A body that does not turn, and the world: one flies off evenly from the other.
    for name, sign in (("ab", -1.0), ("flat", 1.0)):
        expected = np.broadcast_to(sign * V, (len(t), 3))
        np.testing.assert_allclose(vectors(told, f"{name}.v"), expected, atol=1e-12)
        np.testing.assert_allclose(vectors(told, f"{name}.a"), 0.0, atol=1e-12)


def test_rates_off_the_centres_and_as_they_speed_up() -> None:
    """A sled that a pulse drives, and a point of a ball that turns above it under gravity."""
    g, pulse = np.array([0.0, 0.0, -9.81]), 3.0
    point = np.array([0.0, 0.4, 0.3])
    sled = cg.motion.Accelerated([[0, pulse], [9, pulse]], direction="x")
    ball = cg.motion.Free(mass=1.0, inertia=np.eye(3), centre=(0, 0, 0), spin=W * AXIS)
    history = (
        cg.Simulation(
            bodies={"sled": (BALL, sled), "ball": (BALL, ball)},
            slaves={},
            contacts=[],
            sensors=[
                cg.RelativeSensor(
                    "seen",
                    ("sled", "ball"),
                    at=[[0, 0, -2.0], point],
                    measures=["velocity", "acceleration"],
                )
            ],
            gravity=g,
            end=1.0,
            step=0.05,
        )
        .run()
        .history
    )
    t, spin = history["time"], W * AXIS
    arm = Rotation.from_rotvec(np.outer(t, spin)).apply(point)
    sled_v = np.outer(t, [pulse, 0, 0])
    v = np.outer(t, g) + np.cross(spin, arm) - sled_v
    a = g + np.cross(spin, np.cross(spin, arm)) - np.array([pulse, 0, 0])
    np.testing.assert_allclose(vectors(history, "seen.v"), v, atol=1e-5)
    np.testing.assert_allclose(vectors(history, "seen.a"), a, atol=1e-5)


CASE = """
units = { length = "mm", mass = "kg", time = "ms" }
time = { end = 1.0, step = 0.1 }
[[body]]
name = "sled"
geometry = { shape = "plane", width = 300, length = 300, centre = [0, 0, -5] }
motion = { kind = "velocity", direction = "x", table = [[0, 2], [1, 2]] }
[[body]]
name = "head"
geometry = { shape = "sphere", radius = 50, centre = [0, 0, 50] }
mass = { total = 4.5 }
motion = { kind = "free", velocity = [5, 0, 0] }
[[slave]]
name = "skin"
points = { body = "head" }
[[contact]]
master = "sled"
slave = "skin"
law = { kind = "penalty", stiffness = 1e-3, per_area = true }
[[sensor]]
name = "excursion"
between = ["sled", "head"]
measures = ["distance", "displacement", "angle", "velocity", "acceleration"]
[output]
formats = ["csv"]
report = false
"""


def test_a_case_has_them(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(CASE, encoding="utf-8")
    case = cg.load_case(path)
    result = cg.run(case, tmp_path / "out")
    np.testing.assert_allclose(result.history["excursion.x"], 3.0 * result.history["time"])
    own = {name for name in result.history if name.startswith("excursion.")}
    assert own == {name for name in columns_of_case(case) if name.startswith("excursion.")}
    units = result.summary["columns"]
    assert [units[f"excursion.{name}"] for name in ("distance", "rate", "angle")] == [
        "mm", "mm/ms", "rad",
    ]  # fmt: skip
    read = cg.open_result(tmp_path / "out")
    assert "x" in read.sensors["excursion"]
    np.testing.assert_allclose(result.history["excursion.vx"], 3.0)
    read.write_mme(tmp_path / "mme", "T1")
    codes = (tmp_path / "mme" / "T1" / "Channel" / "T1.chn").read_text()
    for code in ("VEX0", "VER0", "ACX0", "ACR0", "DS00", "AN00"):
        assert f"10EXCU000000{code} / excursion " in codes


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('["sled", "head"]', '["sled", "hed"]', r"sensor\[0\].between\[1\]: no body .*'head'"),
        ('["sled", "head"]', '["sled"]', r"sensor\[0\].between: has the wrong length"),
        ('["sled", "head"]', '["sled", "sled"]', "must be two bodies"),
        ('["distance", "displacement", "angle"', '["a"', "measures: is not known"),
        (
            '["sled", "head"]',
            '["sled", "head"]\nbody = "sled"',
            "keys body, between",
        ),
        ('"excursion"', '"head"', "must have a name of its own"),
    ],
)
def test_wrong_ones_are_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = tmp_path / "case.toml"
    assert old in CASE
    head, tail = CASE.split("[[sensor]]")
    path.write_text(head + "[[sensor]]" + tail.replace(old, new), encoding="utf-8")
    with pytest.raises((CaseError, InputError), match=said):
        cg.build(cg.load_case(path))
