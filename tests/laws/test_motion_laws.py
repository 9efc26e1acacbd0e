"""Velocities of motions are the derivatives of their positions, however motions are combined."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contiga.dynamics import Combine, Fixed, Moved, Poses, Rotate, Translate
from contiga.dynamics.prescribed import BodyMotion, SlaveMotion
from contiga.io.mesh.series import MeshSeries
from contiga.rigid import pose

seeds = st.integers(0, 2**32 - 1)
SPAN = 5.0
STEP = 1e-5


def some_motion(rng: np.random.Generator, depth: int = 2) -> BodyMotion:
    """A motion with rows at 0 and 5 and some between."""
    times = np.concatenate([[0.0], np.sort(rng.uniform(0.5, 4.5, 3)), [SPAN]])
    kind = rng.integers(5 if depth else 4)
    if kind == 0:
        return Translate(np.column_stack([times, rng.normal(size=(5, 3))]))
    if kind == 1:
        angles = np.cumsum(rng.normal(scale=90.0, size=5))
        return Rotate(np.column_stack([times, angles]), rng.normal(size=3), rng.normal(size=3))
    if kind == 2:
        angles = rng.normal(size=(5, 3))
        return Poses(times, [pose.from_euler(a, "xyz", rng.normal(size=3)) for a in angles])
    if kind == 3:
        return Fixed()
    return Combine([some_motion(rng, depth - 1) for _ in range(rng.integers(1, 4))])


def slope(positions: list[np.ndarray]) -> np.ndarray:
    """Fourth-order central difference of positions at t − 2h, t − h, t + h, t + 2h."""
    a, b, c, d = positions
    return (a - 8.0 * b + 8.0 * c - d) / (12.0 * STEP)


def smooth_time(rng: np.random.Generator, motion: object) -> float:
    """A time away from all rows of all tables inside."""
    rows: list[float] = []
    waiting = [motion]
    while waiting:
        one = waiting.pop()
        rows += list(getattr(one, "times", ()))
        waiting += list(getattr(one, "motions", ()))
        waiting += [
            x for x in (getattr(one, "motion", None), getattr(one, "base", None)) if x is not None
        ]
    while True:
        t = float(rng.uniform(-1.0, SPAN + 1.0))
        if not rows or np.abs(np.array(rows) - t).min() > 3.0 * STEP:
            return t


def around(t: float) -> tuple[float, ...]:
    return t - 2 * STEP, t - STEP, t + STEP, t + 2 * STEP


@given(seed=seeds)
def test_a_twist_is_the_derivative_of_the_pose(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = some_motion(rng)
    t = smooth_time(rng, motion)
    points = rng.normal(size=(4, 3))
    X = motion.pose(t)
    expected = slope([pose.apply(motion.pose(s), points) for s in around(t)])
    actual = motion.twist(t).at(X[:3, 3], pose.apply(X, points))
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=1e-7)


@given(seed=seeds)
def test_velocities_of_carried_points_are_the_derivatives_of_their_places(seed: int) -> None:
    rng = np.random.default_rng(seed)
    inner: SlaveMotion = Moved(rng.normal(size=(4, 3)), some_motion(rng))
    motion = Moved(inner, some_motion(rng))
    t = smooth_time(rng, motion)
    expected = slope([motion.points(s) for s in around(t)])
    np.testing.assert_allclose(motion.velocities(t), expected, rtol=0.0, atol=1e-7)


def test_at_a_row_the_piece_that_begins_there_says_the_velocity() -> None:
    motion = Translate([[0, 0, 0, 0], [1, 2, 0, 0], [2, 2, 5, 0]])
    for t, velocity in (
        (-0.1, [0, 0, 0]),
        (0.0, [2, 0, 0]),
        (0.99, [2, 0, 0]),
        (1.0, [0, 5, 0]),
        (2.0, [0, 5, 0]),
        (2.01, [0, 0, 0]),
    ):
        np.testing.assert_allclose(motion.twist(t).velocity, velocity)
    assert not Translate([[0, 1, 2, 3]]).twist(0.0).velocity.any()


def test_half_a_turn_and_more_between_two_poses_goes_the_way_of_the_pose() -> None:
    """Half a turn has two ways that are as long: the velocity is of the one that is gone."""
    for angle in (np.pi, 0.999 * np.pi, 1.001 * np.pi, 1e-9):
        end = pose.rotation([1.0, 2.0, -1.0], angle)
        motion = Poses([0.0, 1.0], [np.eye(4), end])
        points = np.array([[1.0, 0.0, 0.0]])
        expected = slope([pose.apply(motion.pose(s), points) for s in around(0.4)])
        actual = motion.twist(0.4).at(np.zeros(3), pose.apply(motion.pose(0.4), points))
        np.testing.assert_allclose(actual, expected, rtol=0.0, atol=1e-7)


def test_velocities_of_a_series_of_files(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    frames = rng.normal(size=(3, 5, 3))
    for k, frame in enumerate(frames):
        meshio.write(
            tmp_path / f"s{k}.vtu", meshio.Mesh(frame, [("vertex", np.arange(5)[:, None])])
        )
    series = MeshSeries([tmp_path / f"s{k}.vtu" for k in range(3)], [0.0, 1.0, 3.0])
    np.testing.assert_allclose(series.velocities(0.5), frames[1] - frames[0], atol=1e-15)
    np.testing.assert_allclose(series.velocities(3.0), 0.5 * (frames[2] - frames[1]), atol=1e-15)
    assert not series.velocities(3.1).any()
    assert series.velocities(-1.0).shape == (5, 3)


@pytest.mark.parametrize("t", [0.0, 2.5, 9.0])
def test_what_is_fixed_has_no_velocity(t: float) -> None:
    velocity, spin = Fixed().twist(t)
    assert not velocity.any()
    assert not spin.any()
