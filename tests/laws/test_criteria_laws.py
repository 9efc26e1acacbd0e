"""What must hold of criteria, whatever the signal."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contiga.criteria import clip, hic


def signal(seed, n, power):
    rng = np.random.default_rng(seed)
    return 100.0 * rng.random(n) ** power, np.cumsum(rng.uniform(0.1, 1.0, n)) * 1e-3


SIGNALS = {
    "seed": st.integers(0, 10**6),
    "n": st.integers(5, 80),
    "power": st.sampled_from([0.0, 0.2, 1.0, 6.0]),
}


@settings(max_examples=60, deadline=None)
@given(**SIGNALS, scale=st.floats(1e-3, 1e3), slow=st.floats(0.1, 10.0), later=st.floats(-9, 9))
def test_criteria_scale_with_signal_and_time(seed, n, power, scale, slow, later):
    a, t = signal(seed, n, power)
    one, other = hic(a, t, 0.003), hic(scale * a, slow * t + later, slow * 0.003)
    assert other.value == pytest.approx(slow * scale**2.5 * one.value, rel=1e-9)
    if t[-1] - t[0] > 0.0011:
        level = clip(a, t, 0.001).value
        assert clip(scale * a, slow * t + later, slow * 0.001).value == pytest.approx(
            scale * level, rel=1e-9
        )


@settings(max_examples=60, deadline=None)
@given(**SIGNALS)
def test_criteria_do_not_know_the_direction_of_time(seed, n, power):
    a, t = signal(seed, n, power)
    back = (a[::-1], t[-1] - t[::-1])
    assert hic(*back, 0.003).value == pytest.approx(hic(a, t, 0.003).value, rel=1e-10)
    for cumulative in (False, True):
        one = clip(a, t, 5e-4, cumulative=cumulative) if t[-1] - t[0] > 5e-4 else None
        if one is not None:
            other = clip(*back, 5e-4, cumulative=cumulative)
            assert other.value == pytest.approx(one.value, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(**SIGNALS, more=st.integers(1, 60))
def test_samples_on_the_line_change_no_hic(seed, n, power, more):
    a, t = signal(seed, n, power)
    extra = np.random.default_rng(seed + 1).uniform(t[0], t[-1], more)
    fine = np.unique(np.concatenate([t, extra]))
    one, other = hic(a, t, 0.003), hic(np.interp(fine, t, a), fine, 0.003)
    assert other.value == pytest.approx(one.value, rel=1e-9)


@settings(max_examples=60, deadline=None)
@given(**SIGNALS)
def test_longer_windows_and_larger_signals_are_not_less(seed, n, power):
    a, t = signal(seed, n, power)
    values = [hic(a, t, window).value for window in (1e-4, 1e-3, 1e-2, np.inf)]
    assert np.all(np.diff(values) >= -1e-12 * values[-1])
    assert hic(a + 1.0, t, 1e-3).value > values[1]
    assert values[-1] <= (t[-1] - t[0]) * a.max() ** 2.5 * (1.0 + 1e-12)
