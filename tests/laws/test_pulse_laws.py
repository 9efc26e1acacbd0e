"""Pulses: velocities are derivatives of places, pieces join, a shift in time shifts all."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.dynamics import Accelerated, Velocity
from contiga.rigid.twist import Twist

seeds = st.integers(0, 2**32 - 1)
STEP = 1e-4
KINDS = [(Velocity, False), (Velocity, True), (Accelerated, False), (Accelerated, True)]


def some_table(rng: np.random.Generator) -> np.ndarray:
    times = np.cumsum(rng.uniform(0.2, 1.5, rng.integers(2, 8))) - 1.0
    return np.column_stack([times, rng.normal(size=(len(times), 3))])


def smooth_time(rng: np.random.Generator, table: np.ndarray) -> float:
    """A time away from the rows, also before and after all."""
    while True:
        t = float(rng.uniform(table[0, 0] - 1.0, table[-1, 0] + 1.0))
        if np.abs(table[:, 0] - t).min() > 3.0 * STEP:
            return t


def slope(of, t: float) -> np.ndarray:
    """Fourth-order central difference."""
    a, b, c, d = (of(t + k * STEP) for k in (-2, -1, 1, 2))
    return (a - 8.0 * b + 8.0 * c - d) / (12.0 * STEP)


@pytest.mark.parametrize(("kind", "smooth"), KINDS)
@settings(deadline=None, max_examples=60)
@given(seed=seeds)
def test_twist_and_acceleration_are_derivatives(kind, smooth, seed) -> None:
    rng = np.random.default_rng(seed)
    table = some_table(rng)
    motion = kind(table, smooth=smooth)
    t = smooth_time(rng, table)
    twist = motion.twist(t)
    assert isinstance(twist, Twist)
    actual = slope(lambda s: motion.pose(s)[:3, 3], t)
    np.testing.assert_allclose(twist.velocity, actual, rtol=0.0, atol=1e-8)
    actual = slope(motion.velocity, t)
    np.testing.assert_allclose(motion.acceleration(t), actual, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize(("kind", "smooth"), KINDS)
@settings(deadline=None, max_examples=60)
@given(seed=seeds)
def test_pieces_join_and_the_first_row_is_at_zero(kind, smooth, seed) -> None:
    table = some_table(np.random.default_rng(seed))
    motion = kind(table, smooth=smooth)
    assert not motion.displacement(table[0, 0]).any()
    for t in table[:, 0]:
        near = 4.0 * np.spacing(abs(t) + 1.0)
        for of in (motion.displacement, motion.velocity):
            np.testing.assert_allclose(of(t - near), of(t), rtol=0.0, atol=1e-13)
            np.testing.assert_allclose(of(t + near), of(t), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize(("kind", "smooth"), KINDS)
@settings(deadline=None, max_examples=60)
@given(seed=seeds, by=st.sampled_from([-8.0, 0.5, 64.0]))
def test_a_shift_in_time_shifts_the_motion(kind, smooth, seed, by) -> None:
    rng = np.random.default_rng(seed)
    table = some_table(rng)
    motion, later = kind(table, smooth=smooth), kind(table + np.array([by, 0, 0, 0]), smooth=smooth)
    t = smooth_time(rng, table)
    for of, same in (
        (motion.displacement, later.displacement),
        (motion.velocity, later.velocity),
        (motion.acceleration, later.acceleration),
    ):
        np.testing.assert_allclose(same(t + by), of(t), rtol=1e-11, atol=1e-11)


@settings(deadline=None, max_examples=60)
@given(seed=seeds, smooth=st.booleans())
def test_a_velocity_is_the_acceleration_that_its_table_has(seed, smooth) -> None:
    """Velocity of the velocities an accelerated body has, linear ones: the same motion."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.2, 1.5, 3))
    slope_, start = rng.normal(size=(2, 3))
    rates = np.column_stack([times, start + (times - times[0])[:, None] * slope_])
    even = np.column_stack([times, np.tile(slope_, (3, 1))])
    by_velocity = Velocity(rates, smooth=smooth)
    by_acceleration = Accelerated(even, velocity=start, smooth=smooth)
    for t in rng.uniform(times[0] - 1.0, times[-1] + 1.0, 5):
        np.testing.assert_allclose(
            by_velocity.displacement(t), by_acceleration.displacement(t), atol=1e-12
        )
