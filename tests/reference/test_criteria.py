"""HIC and the 3 ms value of pulses whose values are known in closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from contiga.criteria import clip, hic

WIDE = math.inf


@pytest.mark.parametrize("n", [2, 3, 1000])
@pytest.mark.parametrize("window", [0.015, 0.036])
def test_a_constant(n, window):
    actual = hic(np.full(n, 80.0), np.linspace(5.0, 5.1, n), window)
    assert actual.value == pytest.approx(window * 80.0**2.5, rel=1e-12)
    assert actual.end - actual.start == pytest.approx(window, rel=1e-9)


def test_a_constant_shorter_than_the_window():
    assert hic([80.0, 80.0], [0.0, 0.01]) == pytest.approx((0.01 * 80.0**2.5, 0.0, 0.01))


TRIANGLE = 4.0 / 7.0
"""Share of the base in the window: 1 − x = 0.6 (1 − x/2)."""


@pytest.mark.parametrize("window", [WIDE, 0.5 * TRIANGLE * 0.03])
@pytest.mark.parametrize("offset", [0.0, 5.0])
def test_a_triangle_on_a_level(offset, window):
    """The level is never left; x = 4/7 (1 + offset / peak) of the base is in the best window."""
    peak, base = 120.0, 0.03
    share = min(TRIANGLE * (1.0 + offset / peak), window / base)
    length = share * base
    exact = length * (offset + peak * (1.0 - 0.5 * share)) ** 2.5
    t = np.array([0.0, 0.05, 0.05 + base / 2, 0.05 + base, 0.2])
    actual = hic(offset + np.array([0.0, 0.0, peak, 0.0, 0.0]), t, min(window, 0.036))
    assert actual.value == pytest.approx(exact, rel=1e-12)
    assert actual.start == pytest.approx(0.05 + (base - length) / 2, abs=1e-12)
    assert actual.end == pytest.approx(0.05 + (base + length) / 2, abs=1e-12)


def test_a_single_sample():
    t = np.arange(1000) * 1e-4
    a = np.zeros(1000)
    a[123] = 500.0
    exact = TRIANGLE * 2e-4 * (500.0 * (1.0 - 0.5 * TRIANGLE)) ** 2.5
    assert hic(a, t).value == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("turned", [False, True])
def test_a_saw_tooth(turned):
    """From 3/7 of the peak to the peak: 0.6 of the mean at one end, the end of the signal there."""
    t, a = np.linspace(0.0, 0.02, 7), np.linspace(0.0, 90.0, 7)
    actual = hic(a[::-1] if turned else a, t, WIDE)
    assert actual.value == pytest.approx(TRIANGLE * 0.02 * (90.0 * 5.0 / 7.0) ** 2.5, rel=1e-12)
    assert actual.end - actual.start == pytest.approx(TRIANGLE * 0.02, rel=1e-12)


def half_sine(n: int, peak: float, duration: float) -> tuple[np.ndarray, np.ndarray]:
    t = np.linspace(0.0, duration, n)
    return peak * np.sin(np.pi * t / duration), t


@pytest.mark.parametrize("window", [0.015, 0.006, 0.036])
def test_a_half_sine_is_reached_with_the_square_of_the_step(window):
    peak, duration = 80.0, 0.02
    best = brentq(lambda x: math.cos(x) - 0.6 * math.sin(x) / x, 0.1, 1.5)
    x = min(best, 0.5 * math.pi * window / duration)
    exact = 2.0 * duration * x / math.pi * (peak * math.sin(x) / x) ** 2.5
    misses = [exact - hic(*half_sine(n, peak, duration), window).value for n in (101, 201, 401)]
    orders = np.log2(np.divide(misses[:-1], misses[1:]))
    assert np.all(np.abs(orders - 2.0) < 0.05)
    assert misses[-1] < 1e-4 * exact


def test_ends_are_found_between_the_samples_of_a_fine_signal():
    """To where both have 0.6 of the mean, a millionth of a step."""
    a, t = half_sine(5001, 80.0, 0.02)
    result = hic(a, t, WIDE)
    mean = (result.value / (result.end - result.start)) ** 0.4
    rise = a[1] - a[0]
    ends = np.interp([result.start, result.end], t, a)
    assert np.abs(ends - 0.6 * mean).max() < 1e-6 * rise


@pytest.mark.parametrize("plateau", [0.002, 0.01])
@pytest.mark.parametrize("ratio", [0.5, 0.6, 0.7])
def test_a_block_on_a_level(ratio, plateau):
    """A block whose sides are steep: the level counts beyond it where it is above 0.6 of it."""
    level, steep = 100.0 * ratio, 1e-9
    t = np.cumsum([0.0, 0.02, steep, plateau, steep, 0.02])
    a = np.array([level, level, 100.0, 100.0, level, level])
    longest = 0.015
    length = np.linspace(plateau, longest, 200_001)
    exact = (length * (level + (100.0 - level) * plateau / length) ** 2.5).max()
    actual = hic(a, t, longest)
    assert actual.value == pytest.approx(exact, rel=1e-6)
    assert hic(a[::-1], t[-1] - t[::-1], longest).value == pytest.approx(actual.value, rel=1e-10)


def test_the_half_sine_is_held_for_3_ms():
    actual = clip(*half_sine(20_001, 80.0, 0.02))
    assert actual.value == pytest.approx(80.0 * math.cos(0.5 * math.pi * 0.003 / 0.02), rel=1e-7)
    assert (actual.start, actual.end) == pytest.approx((0.0085, 0.0115), abs=1e-8)


@pytest.mark.parametrize("cumulative", [False, True])
def test_triangles_are_held_for_3_ms(cumulative):
    """Three, of bases 8, 16, 8 ms: above a level of x each is for (1 − x) of its base."""
    t = np.array([0, 4, 8, 16, 24, 28, 32]) * 1e-3
    a = np.array([0.0, 50.0, 0.0, 50.0, 0.0, 50.0, 0.0])
    base = 0.032 if cumulative else 0.016
    actual = clip(a, t, cumulative=cumulative)
    assert actual.value == pytest.approx(50.0 * (1.0 - 0.003 / base), rel=1e-12)
