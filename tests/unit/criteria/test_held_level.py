"""The 3 ms value: against levels tried one by one, invariants, and bad input."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from contiga.criteria import Clip, clip
from contiga.errors import InputError


def held(a, t, level, cumulative):
    """How long the line through samples is at `level` or above, from 200 points a piece."""
    fine = np.unique(np.concatenate([np.linspace(p, q, 201) for p, q in pairwise(t)]))
    above = np.interp(fine, t, a) >= level
    steps = np.diff(fine) * (above[1:] & above[:-1])
    if cumulative:
        return steps.sum()
    total = best = 0.0
    for step in steps:
        total = total + step if step > 0.0 else 0.0
        best = max(best, total)
    return best


def signal(seed: int):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 40))
    t = np.cumsum(rng.uniform(0.2, 1.0, n)) * 1e-3 + rng.uniform(-1, 1)
    a = rng.choice([0.0, 20.0, 30.0, 50.0], n) if seed % 3 == 0 else rng.uniform(0.0, 100.0, n)
    return a, t


@pytest.mark.parametrize("cumulative", [False, True])
@pytest.mark.parametrize("seed", range(25))
def test_the_level_is_the_largest_that_is_held(seed, cumulative):
    a, t = signal(seed)
    duration = 0.3 * (t[-1] - t[0])
    actual = clip(a, t, duration, cumulative=cumulative)
    slack = 0.012 * (t[-1] - t[0])
    assert held(a, t, actual.value - 1e-9, cumulative) >= duration - slack
    assert held(a, t, actual.value + 1e-6, cumulative) <= duration + slack
    if not cumulative:
        inside = np.linspace(actual.start, actual.end, 999)
        assert actual.end - actual.start >= duration * (1.0 - 1e-12)
        assert np.interp(inside, t, a).min() >= actual.value - 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_samples_on_the_line_change_nothing(seed):
    a, t = signal(seed)
    more = np.unique(np.concatenate([t, np.random.default_rng(seed).uniform(t[0], t[-1], 50)]))
    one, other = clip(a, t, 0.002), clip(np.interp(more, t, a), more, 0.002)
    assert other == pytest.approx(one, rel=1e-9)


def test_two_peaks_count_together_only_when_asked():
    t = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    a = np.array([0.0, 10.0, 0.0, 10.0, 0.0])
    assert clip(a, t, 1.0) == Clip(5.0, 0.5, 1.5)
    assert clip(a, t, 1.0, cumulative=True) == Clip(7.5, 0.75, 3.25)


def test_a_saddle_joins_two_peaks():
    """At its own level, and not just above."""
    t, a = np.arange(5.0), np.array([0.0, 10.0, 4.0, 10.0, 0.0])
    actual = clip(a, t, 2.5)
    assert actual.value == 4.0
    assert (actual.start, actual.end) == pytest.approx((0.4, 3.6))


def test_a_plateau_is_held_as_long_as_it_lasts():
    t, a = np.arange(0.0, 0.0101, 1e-4), np.zeros(101)
    a[20:51] = 70.0
    assert clip(a, t).value == pytest.approx(70.0, rel=1e-12)
    assert clip(a, t, 0.0031).value == pytest.approx(35.0, rel=1e-9)


def test_a_signal_may_be_as_long_as_the_time():
    t = np.arange(31) * 1e-4
    assert clip(np.full(31, 7.0), t).value == 7.0
    assert clip(np.linspace(1.0, 2.0, 31), t).value == 1.0


def test_the_ends_of_the_signal_end_what_is_held():
    assert clip([10.0, 0.0], [0.0, 1.0], 0.25) == Clip(7.5, 0.0, 0.25)
    assert clip([0.0, 10.0], [0.0, 1.0], 0.25) == Clip(7.5, 0.75, 1.0)


def test_a_signal_too_short_is_refused():
    with pytest.raises(InputError, match=r"clip, t_s: the signal is shorter.*found 0.002;.*0.003"):
        clip([1.0, 2.0], [0.0, 0.002])


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf])
def test_durations_are_positive(duration):
    with pytest.raises(InputError, match="clip, duration: must be positive"):
        clip([1.0, 2.0], [0.0, 1.0], duration)
