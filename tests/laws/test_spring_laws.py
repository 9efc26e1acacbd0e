"""Springs in numbers and laws of a contact in arrays say the same of every path."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.dynamics.spring_curves import spring_law
from contiga.dynamics.springs import Spring
from contiga.laws.characteristic import Characteristic
from contiga.laws.hysteresis import Hysteresis

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


@settings(deadline=None, max_examples=200)
@given(seed=seeds)
def test_a_belt_is_the_hysteresis_of_a_contact(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pad = some_hysteresis(rng)
    law = spring_law(pad.loading, pad)
    size = 1.0 + float(pad.loading.y.max())
    x_old = force = 0.0
    for x in rng.uniform(0.0, 1.3 * pad.loading.x[-1], 12) * rng.choice(
        [0.0, 1.0], 12, p=[0.1, 0.9]
    ):
        moved = pad.move(np.array([x_old]), np.array([force]), np.array([x]))
        mine = law.move(x_old, force, float(x))
        for own, other in (
            (mine.force, moved.force),
            (mine.stored, moved.stored),
            (mine.lost, moved.lost),
        ):
            np.testing.assert_allclose(own, other[0], rtol=1e-11, atol=1e-12 * size)
        x_old, force = float(x), mine.force


@settings(deadline=None, max_examples=100)
@given(seed=seeds)
def test_the_stiffness_of_a_belt_is_that_of_the_curve_or_line_it_is_on(seed: int) -> None:
    rng = np.random.default_rng(seed)
    pad = some_hysteresis(rng)
    law = spring_law(pad.loading, pad)
    x_old = force = 0.0
    for x in rng.uniform(0.05, 1.3 * pad.loading.x[-1], 6):
        moved = pad.move(np.array([x_old]), np.array([force]), np.array([x]))
        mine = law.move(x_old, force, float(x))
        edges = np.concatenate([pad.loading.polyline[0], pad.unloading.polyline[0]])
        on_two = abs(force + pad.slope * (x - x_old) - mine.force) < 1e-9 * (1.0 + abs(mine.force))
        if np.abs(edges - x).min() > 1e-9 and not on_two:
            np.testing.assert_allclose(mine.stiffness, moved.stiffness[0], rtol=1e-9, atol=1e-12)
        x_old, force = float(x), mine.force


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
    law = spring_law(curve, None)
    a, b = np.sort(rng.uniform(x[0] - 1.0, x[-1] + 1.0, 2))
    nodes = np.unique(np.concatenate([[a, b], x[(x > a) & (x < b)]]))
    y = curve(nodes)
    work = float((0.5 * (y[1:] + y[:-1]) * np.diff(nodes)).sum())
    gained = law.move(0.0, 0.0, float(b)).stored - law.move(0.0, 0.0, float(a)).stored
    assert abs(gained - work) <= 1e-12 * (1.0 + abs(y).max())
