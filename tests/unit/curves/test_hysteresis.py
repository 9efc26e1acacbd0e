"""Hysteresis against closed forms: where the force goes, what is stored, what is lost."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.curves.characteristic import Characteristic
from contiga.curves.hysteresis import Hysteresis

# Loads along x, unloads along x − 1/2 where that is above zero: a set of 1/2. From (1, 1) down the
# line of slope 4 to (5/6, 1/3): stored 1/9 + 1/18.
LOADING, UNLOADING, K = 1.0, [[0, 0], [0.5, 0], [1.5, 1]], 4.0
PAD = Hysteresis(Characteristic(LOADING), Characteristic(UNLOADING), K)
PAD_OF_FUNCTIONS = Hysteresis(
    Characteristic(lambda x: x), Characteristic(lambda x: np.maximum(x - 0.5, 0.0)), K
)


def run(pad: Hysteresis, path) -> list:
    """The steps of one point along `path`, from nothing."""
    x, force, steps = np.zeros(1), np.zeros(1), []
    for value in path:
        moved = pad.move(x, force, np.array([float(value)]))
        x, force = np.array([float(value)]), moved.force
        steps.append(moved)
    return steps


@pytest.mark.parametrize("pad", [PAD, PAD_OF_FUNCTIONS], ids=["tables", "functions"])
def test_the_force_goes_up_the_loading_down_the_line_and_the_unloading_and_up_the_line(pad) -> None:
    path = [0.4, 1.0, 0.9, 5 / 6, 0.7, 0.5, 0.2, 0.5, 0.7, 0.72, 0.9, 1.2]
    force = [0.4, 1.0, 0.6, 1 / 3, 0.2, 0.0, 0.0, 0.5, 0.7, 0.72, 0.9, 1.2]
    np.testing.assert_allclose([m.force[0] for m in run(pad, path)], force, rtol=1e-9, atol=1e-9)


def test_what_is_stored_at_the_peak_is_what_the_way_down_gives_back() -> None:
    peak, zero = run(PAD, [1.0, 0.0])
    assert peak.stored[0] == pytest.approx(1 / 9 + 1 / 18, rel=1e-14)
    assert peak.lost[0] == pytest.approx(0.5 - 1 / 6, rel=1e-14)
    assert (zero.stored[0], zero.lost[0], zero.force[0]) == (0.0, 0.0, 0.0)


def test_functions_are_met_and_integrated_to_rounding() -> None:
    """x² and x²/2: the line from (1, 1) meets where s² − 8 s + 6 = 0."""
    pad = Hysteresis(Characteristic(lambda x: x**2), Characteristic(lambda x: 0.5 * x**2), K)
    s = 4.0 - np.sqrt(10.0)
    stored = (1.0 - s) * (1.0 - 0.5 * K * (1.0 - s)) + s**3 / 6.0
    peak, _ = run(pad, [1.0, 0.0])
    assert peak.stored[0] == pytest.approx(stored, rel=1e-13)
    for steps in (1, 7, 50):
        ways = np.linspace(0.0, 1.0, steps + 1), np.linspace(1.0, 0.0, steps + 1)
        lost = sum(m.lost[0] for m in run(pad, np.concatenate([ways[0][1:], ways[1][1:]])))
        assert lost == pytest.approx(1.0 / 3.0 - stored, rel=1e-12)


def test_the_stiffness_is_that_of_the_curve_or_the_line_the_force_is_on() -> None:
    steps = run(PAD, [0.4, 1.0, 0.9, 0.7, 0.3, 0.35, 1.2])
    assert [m.stiffness[0] for m in steps] == [1.0, 1.0, K, 1.0, 0.0, K, 1.0]


def test_where_the_curves_touch_the_stiffness_is_that_of_more_load() -> None:
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [2, 3]]), Characteristic([[0, 0], [1, 1], [2, 2]]), 5.0
    )
    assert [m.stiffness[0] for m in run(pad, [1.0, 1.5, 1.0])] == [2.0, 2.0, 2.0]


@pytest.mark.parametrize("steps", [1, 7, 1000])
def test_a_cycle_loses_the_area_between_the_curves_whatever_the_steps(steps: int) -> None:
    up, down = np.linspace(0.0, 1.0, steps + 1), np.linspace(1.0, 0.0, steps + 1)
    lost = sum(m.lost[0] for m in run(PAD, [*up[1:], *down[1:]]))
    assert lost == pytest.approx(1 / 3, rel=1e-12)


def test_a_small_cycle_inside_loses_its_own_parallelogram() -> None:
    """(0.7, 0.2) up the line to L at 13/15, along L to 0.95, down to U: between two lines."""
    start = 13 / 15
    lost = [m.lost[0] for m in run(PAD, [1.0, 0.7, 0.95, 0.7])]

    def stored(x: float) -> float:
        s = (K * x - x - 0.5) / (K - 1.0)
        return (x - s) * (x - K * (x - s) / 2) + 0.5 * (s - 0.5) ** 2

    work = 0.5 * (0.95**2 - start**2)
    assert lost[2] == pytest.approx(work - stored(0.95) + stored(start), rel=1e-11)
    assert lost[1] == lost[3] == 0.0


def test_a_softening_curve_loses_what_the_force_gives_up() -> None:
    """Up to 1 at 1 and down to 0 at 2: all the work is lost, as nothing is left to give back."""
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [2, 0]]), Characteristic([[0, 0], [2, 0]]), 3.0
    )
    steps = run(pad, np.linspace(0.0, 2.5, 37)[1:])
    assert steps[-1].force[0] == steps[-1].stored[0] == 0.0
    assert sum(m.lost[0] for m in steps) == pytest.approx(1.0, rel=1e-12)
    assert min(m.lost[0] for m in steps) >= -1e-15


def test_an_unloading_that_its_extrapolation_takes_below_zero_counts_as_zero_there() -> None:
    pad = Hysteresis(
        Characteristic([[0, 0], [1, 1], [3, 1]]),
        Characteristic([[0, 0], [1, 0.9], [1.2, 0.1]]),
        5.0,
    )
    assert [m.force[0] for m in run(pad, [3.0, 2.5, 2.81])] == [1.0, 0.0, 1.0]


def test_a_preload_starts_between_the_curves_at_zero() -> None:
    pad = Hysteresis(
        Characteristic([[0, 3.0], [1, 4.0]]), Characteristic([[0, 1.0], [1, 1.0]]), 10.0
    )
    steps = run(pad, [0.1, 1.0, 0.0])
    assert [m.force[0] for m in steps] == pytest.approx([2.0, 4.0, 1.0])
    whole = run(pad, [1.0, 0.0])
    assert sum(m.lost[0] for m in steps) == pytest.approx(sum(m.lost[0] for m in whole))


def test_a_line_as_steep_as_a_curve_is_allowed_and_loses_nothing_on_it() -> None:
    pad = Hysteresis(Characteristic(2.0), Characteristic(2.0), 2.0)
    steps = run(pad, [0.3, 0.1, 0.7, 0.2])
    assert [m.force[0] for m in steps] == pytest.approx([0.6, 0.2, 1.4, 0.4])
    assert max(abs(m.lost[0]) for m in steps) < 1e-15


@pytest.mark.interpreted
def test_tables_with_hysteresis_do_what_functions_of_the_same_shape_do() -> None:
    up, down = [[0, 0], [0.3, 1.0], [1.0, 1.4], [2.0, 4.0]], [[0, 0], [0.4, 0.0], [2.0, 2.0]]
    exact = Hysteresis(Characteristic(up), Characteristic(down), 8.0)
    functions = [
        Characteristic(lambda x, c=curve: np.interp(x, c.x, c.y))
        for curve in (exact.loading, exact.unloading)
    ]
    bracketed = Hysteresis(*functions, 8.0)
    rng = np.random.default_rng(2)
    x_old, x = rng.uniform(0.0, 1.9, (2, 25))
    low, high = exact.unloading.carried(x_old), exact.loading.carried(x_old)
    f_old = low + rng.uniform(0.0, 1.0, 25) * (high - low)
    x_old[:3], f_old[:3] = 0.0, [-1.0, 0.0, 5.0]  # without a past
    one, other = exact.move(x_old, f_old, x), bracketed.move(x_old, f_old, x)
    np.testing.assert_allclose(one.force, other.force, rtol=0, atol=1e-12)
    # Gauss's rule over kinks is good to a few thousandths.
    np.testing.assert_allclose(one.stored, other.stored, rtol=0, atol=5e-3)
    np.testing.assert_allclose(one.lost, other.lost, rtol=0, atol=5e-3)
    assert one.lost.max() > 0.1
    assert set(np.round(one.stiffness, 9)) > {8.0}


@pytest.mark.interpreted
def test_one_point_does_what_many_do_and_forgets_below_zero() -> None:
    """Of tables and of functions: a walk that turns, leaves below zero and goes beyond the ends."""
    steps = np.random.default_rng(0).normal(size=60) * 0.15
    walk = np.abs(np.cumsum(steps)) % 2.0
    walk[20:23] = -0.1
    curves = Characteristic([[0, 3.0], [1, 4.0]]), Characteristic([[0, 1.0], [1, 1.5]])
    preloaded = Hysteresis(*curves, 10.0)
    for pad in (PAD, PAD_OF_FUNCTIONS, preloaded):
        x_old = force = 0.0
        for x in walk:
            found = pad.step(x_old, force, float(x))
            expected = [0.0, 0.0, 0.0, 0.0]
            if x >= 0.0:
                past = np.array([max(x_old, 0.0)]), np.array([force])
                expected = [column[0] for column in pad.move(*past, np.array([x]))]
            assert found == tuple(expected)
            x_old, force = float(x), found.force
