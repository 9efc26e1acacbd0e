"""Springs against the definition of their energies, over any path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.curves.characteristic import Characteristic
from contiga.curves.hysteresis import Hysteresis
from contiga.dynamics.spring_law import SpringLaw
from contiga.dynamics.springs import Spring

seeds = st.integers(0, 2**32 - 1)
STILL = np.zeros((2, 3))


def some_hysteresis(rng: np.random.Generator) -> Hysteresis:
    """Tables with flat pieces, permanent sets, falling pieces, of many slopes."""
    x = np.append(0.0, np.cumsum(rng.uniform(0.1, 1.0, rng.integers(1, 6))))
    rise = rng.choice([0.0, 1.0, -0.2], len(x) - 1, p=[0.2, 0.7, 0.1]) * rng.exponential(2.0)
    start = rng.choice([0.0, 1.0])
    y = np.maximum(start + np.append(0.0, np.cumsum(rise * rng.uniform(0.2, 3.0, len(rise)))), 0.0)
    share = np.maximum(rng.uniform(-0.3, 1.0, len(x)), 0.0)
    loading = Characteristic(np.column_stack([x, y]), extrapolation="constant")
    unloading = Characteristic(np.column_stack([x, share * y]), extrapolation="constant")
    steepest = max(float((np.diff(c.y) / np.diff(c.x)).max()) for c in (loading, unloading))
    return Hysteresis(loading, unloading, max(steepest, 0.5) * rng.choice([1.0, 1.3, 8.0]))


def plain(pad: Hysteresis, x_old: float, f_old: float, x: float) -> tuple[float, float, float]:
    """Force, stored and lost energy by the definition, areas by fine sums."""

    def area(force: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> float:
        middles = low + (np.arange(20_000) + 0.5) * (high - low) / 20_000
        return float(force(middles).mean() * (high - low))

    def upper(s: np.ndarray) -> np.ndarray:
        return np.interp(s, pad.loading.x, pad.loading.y)

    def lower(s: np.ndarray) -> np.ndarray:
        return np.interp(s, pad.unloading.x, pad.unloading.y)

    def stored(end: float, force: float) -> float:
        return area(lambda s: np.maximum(force + pad.slope * (s - end), lower(s)), 0.0, end)

    at = np.array([x])
    if x_old <= 0.0:
        zero = np.zeros(1)
        f_old = float(np.clip(f_old, lower(zero), upper(zero))[0])
    force = float(np.clip(f_old + pad.slope * (x - x_old), lower(at), upper(at))[0])
    lost = 0.0
    if x > x_old:
        work = area(lambda s: np.minimum(f_old + pad.slope * (s - x_old), upper(s)), x_old, x)
        lost = work - (stored(x, force) - stored(x_old, f_old))
    return force, stored(x, force), lost


@settings(deadline=None, max_examples=60)
@given(seed=seeds)
def test_a_belt_does_what_hysteresis_is_defined_by(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pad = some_hysteresis(rng)
    law = SpringLaw(pad.loading, pad)
    end = float(pad.loading.x[-1])
    size = 1.0 + float(pad.loading.y.max())
    x_old = force = 0.0
    for x in rng.uniform(0.0, 1.3 * end, 8) * rng.choice([0.0, 1.0], 8, p=[0.1, 0.9]):
        found = law.move(x_old, force, float(x))
        expected = plain(pad, x_old, force, float(x))
        assert abs(found.force - expected[0]) <= 1e-12 * size
        energies = np.array([found.stored, found.lost])
        np.testing.assert_allclose(energies, expected[1:], rtol=0, atol=1e-6 * size * (1.0 + end))
        x_old, force = float(x), found.force


@settings(deadline=None, max_examples=100)
@given(seed=seeds)
def test_the_stiffness_of_a_belt_is_the_slope_of_its_force(seed: int) -> None:
    """The slope is that between steps from one start to both sides of x, where that is smooth."""
    rng = np.random.default_rng(seed)
    pad = some_hysteresis(rng)
    law = SpringLaw(pad.loading, pad)
    x_old = force = 0.0
    for x in rng.uniform(0.05, 1.3 * pad.loading.x[-1], 6):
        found = law.move(x_old, force, float(x))
        h = 1e-6
        below, above = (law.move(x_old, force, float(x) + side) for side in (-h, h))
        left, right = (found.force - below.force) / h, (above.force - found.force) / h
        if abs(right - left) < 1e-6 * (1.0 + pad.slope):
            np.testing.assert_allclose(found.stiffness, right, rtol=0, atol=1e-6 * (1 + pad.slope))
        x_old, force = float(x), found.force


@settings(deadline=None, max_examples=60)
@given(seed=seeds, pieces=st.integers(2, 30))
def test_a_leg_in_one_step_or_many_ends_in_the_same_state(seed: int, pieces: int) -> None:
    rng = np.random.default_rng(seed)
    pad = some_hysteresis(rng)
    at = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
    belt = Spring(
        ("a", "ground"),
        at=at,
        curve=pad.loading,
        unloading=pad.unloading,
        hysteresis_slope=pad.slope,
    )

    def to(x: float) -> np.ndarray:
        return at + np.array([[0.0, 0.0, 0.0], [x, 0.0, 0.0]])

    few = many = belt.start(at, STILL)
    last = 0.0
    for x in rng.uniform(0.0, 3.0, 6):
        few = belt.step(few, to(x), STILL)
        for s in np.linspace(last, x, pieces + 1)[1:]:
            many = belt.step(many, to(s), STILL)
        last = float(x)
        size = 1.0 + float(pad.loading(3.0)) + pad.slope
        np.testing.assert_allclose(many[1:-1], few[1:-1], rtol=1e-9, atol=1e-11 * size)


@settings(deadline=None, max_examples=60)
@given(seed=seeds)
def test_what_an_elastic_spring_stores_is_the_work_of_its_force(seed: int) -> None:
    """Over any way, by a rule that is exact between the kinks of the table."""
    rng = np.random.default_rng(seed)
    x = np.cumsum(rng.uniform(0.1, 1.0, 5)) - rng.uniform(0.0, 3.0)
    curve = Characteristic(np.column_stack([x, rng.normal(size=5)]))
    law = SpringLaw(curve, None)
    a, b = np.sort(rng.uniform(x[0] - 1.0, x[-1] + 1.0, 2))
    nodes = np.unique(np.concatenate([[a, b], x[(x > a) & (x < b)]]))
    y = curve(nodes)
    work = float((0.5 * (y[1:] + y[:-1]) * np.diff(nodes)).sum())
    gained = law.move(0.0, 0.0, float(b)).stored - law.move(0.0, 0.0, float(a)).stored
    assert abs(gained - work) <= 1e-12 * (1.0 + abs(y).max())
