"""Free rigid bodies: turns against closed forms, what is kept, what is held."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contiga.dynamics.free import Free
from contiga.dynamics.rigid_bodies import (
    Placed,
    bodies_at_start,
    drift_bodies,
    fixed_of,
    kick_bodies,
    row_of,
)
from contiga.errors import InputError
from contiga.records import FloatArray, MassProperties
from contiga.rigid import quaternion
from contiga.rigid import rigid_lanes as lanes

pytestmark = pytest.mark.interpreted

TOP = np.array([[1.0, 0.2, 0.1], [0.2, 2.0, 0.3], [0.1, 0.3, 2.5]])


def flown(motion: Free, time: float, steps: int, loads: FloatArray | None = None) -> Placed:
    """A body after a flight with a constant load about its frame's origin."""
    fixed = fixed_of("top", motion)[None]
    placed = bodies_at_start(row_of(motion, fixed[0])[None], fixed)
    own = np.zeros((1, 6)) if loads is None else loads
    kick_bodies(placed, fixed, own, 0.0)
    for _ in range(steps):
        placed = drift_bodies(placed.rows, fixed, time / steps)
        kick_bodies(placed, fixed, own, time / steps)
    return placed


def energy_of(placed: Placed, motion: Free) -> float:
    fixed = fixed_of("top", motion)[None]
    again = Placed(placed.rows.copy(), placed.poses, placed.twists.copy())
    return kick_bodies(again, fixed, np.zeros((1, 6)), 0.0)


def turned(placed: Placed) -> FloatArray:
    return placed.poses[0, :3, :3]


def test_a_symmetric_top_is_exact_at_any_step() -> None:
    """It turns about its momentum at L/I₁ and about its own axis at the rest of its spin."""
    one, axis = 2.0, np.array([0.0, 0.0, 1.0])
    inertia = np.diag([one, one, 0.7])
    spin = np.array([0.3, -0.2, 1.1])
    motion = Free(1.5, inertia=inertia, spin=spin)
    momentum, time = inertia @ spin, 7.3
    own = spin[2] * (1.0 - 0.7 / one)
    expected = Rotation.from_rotvec(momentum / one * time) * Rotation.from_rotvec(own * time * axis)
    for steps in (1, 5, 40):
        np.testing.assert_allclose(
            turned(flown(motion, time, steps)), expected.as_matrix(), rtol=0.0, atol=1e-13
        )


def test_a_body_of_three_moments_keeps_its_momentum_and_turns_with_second_order() -> None:
    motion = Free(1.0, inertia=TOP, spin=[0.1, 1.0, 0.2])
    before = row_of(motion, fixed_of("top", motion))[lanes.MOMENTUM :][:3]
    fine = turned(flown(motion, 10.0, 8000))
    errors = []
    for steps in (250, 500, 1000):
        placed = flown(motion, 10.0, steps)
        np.testing.assert_array_equal(placed.rows[0, lanes.MOMENTUM :][:3], before)
        errors.append(np.abs(turned(placed) - fine).max())
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert (np.abs(orders - 2.0) < 0.1).all()


def test_its_energy_comes_back() -> None:
    """Bounded over ten thousand steps, and second order."""
    motion = Free(1.0, inertia=np.diag([1.0, 2.0, 2.8]), spin=[0.05, 1.0, 0.1])
    fixed = fixed_of("top", motion)[None]
    worst = []
    for step in (0.04, 0.02):
        placed = bodies_at_start(row_of(motion, fixed[0])[None], fixed)
        first = energy_of(placed, motion)
        drift = np.empty(2000)
        for k in range(len(drift)):
            placed = drift_bodies(placed.rows, fixed, step)
            drift[k] = abs(energy_of(placed, motion) / first - 1.0)
        assert drift[1000:].max() < 1.05 * drift[:1000].max()
        worst.append(drift.max())
    assert worst[0] / worst[1] == pytest.approx(4.0, rel=0.1)


def test_a_flight_under_a_constant_force_is_exact() -> None:
    motion = Free(2.0, inertia=np.eye(3), velocity=[1.0, 0.0, 3.0])
    force = np.array([[0.0, 1.0, -4.0, 0.0, 0.0, 0.0]])
    placed = flown(motion, 3.0, 4, force)
    np.testing.assert_allclose(placed.rows[0, :3], [3.0, 2.25, 0.0], atol=1e-14)
    np.testing.assert_allclose(placed.rows[0, lanes.VELOCITY :][:3], [1.0, 1.5, -3.0], atol=1e-14)


def test_the_frame_goes_with_a_centre_that_is_elsewhere() -> None:
    centre = np.array([1.0, -2.0, 0.5])
    motion = Free(2.0, inertia=TOP, centre=centre, velocity=[0.0, 0.0, 1.0], spin=[0.3, 0.1, 0.9])
    placed = flown(motion, 2.0, 50)
    X = placed.poses[0]
    np.testing.assert_allclose(X[:3, :3] @ centre + X[:3, 3], placed.rows[0, :3], atol=1e-14)
    spin, arm = placed.twists[0, 3:], X[:3, 3] - placed.rows[0, :3]
    expected = np.array([0.0, 0.0, 1.0]) + np.cross(spin, arm)
    np.testing.assert_allclose(placed.twists[0, :3], expected, atol=1e-14)


@pytest.mark.parametrize("hold", [["rz"], ["rx"], ["rx", "ry"], ["ry", "rz"], ["rx", "ry", "rz"]])
def test_held_turns_stay_and_the_others_keep_their_energy(hold: list[str]) -> None:
    free = np.array([axis not in hold for axis in ("rx", "ry", "rz")])
    motion = Free(1.0, inertia=TOP, spin=free * [0.3, 0.7, 0.8], hold=hold)
    first = energy_of(flown(motion, 1.0, 0), motion)
    worst = []
    for steps in (50, 100):
        placed = flown(motion, 2.0, steps)
        assert (placed.twists[0, 3:][~free] == 0.0).all()
        worst.append(abs(energy_of(placed, motion) - first))
    assert worst[1] < 1e-3 * first + 1e-15
    assert worst[1] <= 0.3 * worst[0] + 1e-15


def test_a_turn_about_one_axis_is_even() -> None:
    motion = Free(1.0, inertia=TOP, spin=[0.0, 0.0, 0.8], hold=["rx", "ry"])
    placed = flown(motion, 2.0, 7)
    expected = Rotation.from_rotvec([0.0, 0.0, 1.6]).as_matrix()
    np.testing.assert_allclose(turned(placed), expected, atol=1e-14)


def test_held_ways_feel_no_force() -> None:
    motion = Free(1.0, hold=["x", "z", "rx", "ry", "rz"])
    placed = flown(motion, 1.0, 3, np.array([[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]]))
    np.testing.assert_allclose(placed.rows[0, :3], [0.0, 1.0, 0.0], atol=1e-15)
    np.testing.assert_array_equal(turned(placed), np.eye(3))


def test_a_torque_turns_a_ball_as_it_turns_a_wheel() -> None:
    motion = Free(1.0, inertia=0.5 * np.eye(3))
    placed = flown(motion, 2.0, 10, np.array([[0.0, 0.0, 0.0, 0.0, 0.3, 0.0]]))
    expected = quaternion.to_matrix(Rotation.from_rotvec([0.0, 1.2, 0.0]).as_quat()[[3, 0, 1, 2]])
    np.testing.assert_allclose(turned(placed), expected, atol=1e-13)
    np.testing.assert_allclose(placed.twists[0, 3:], [0.0, 1.2, 0.0], atol=1e-14)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"mass": 0.0}, "positive"),
        ({"mass": 1.0, "inertia": np.diag([1.0, 1.0, 3.0])}, "larger than the sum"),
        ({"mass": 1.0, "hold": ["w"]}, "nothing of this name"),
        ({"mass": 1.0, "hold": "x", "velocity": [1.0, 0.0, 0.0]}, "is held"),
        ({"mass": 1.0, "velocity": [np.nan, 0.0, 0.0]}, "finite"),
        ({"mass": [1.0, -1.0]}, "above zero"),
        (
            {"mass": MassProperties(1.0, np.zeros(3), np.eye(3)), "inertia": np.eye(3)},
            "given twice",
        ),
    ],
)
def test_what_cannot_move_is_refused(options: dict[str, object], match: str) -> None:
    with pytest.raises(InputError, match=match):
        Free(**options)  # type: ignore[arg-type]


def test_a_body_that_may_turn_needs_its_inertia() -> None:
    with pytest.raises(InputError, match="needs its inertia"):
        fixed_of("top", Free(1.0))
    with pytest.raises(InputError, match="needs one mass"):
        fixed_of("top", Free())
