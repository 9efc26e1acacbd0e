"""Injury criteria and filters of signals whose values are known."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from contiga import criteria
from contiga_validation.closed_forms.case import Answer, Cases, Check, order_of, relative
from contiga_validation.closed_forms.pictures import Drawing, comparison
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import INK, LINES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXACT = 1e-12
CASES = Cases("Injury criteria")
PEAK, LENGTH = 100.0, 0.02


def _half_sine(n: int) -> tuple[FloatArray, FloatArray]:
    """Return times (n + 1,), s, and a half sine of `PEAK` g and `LENGTH` s at them."""
    t = np.linspace(0.0, LENGTH, n + 1)
    return t, np.abs(PEAK * np.sin(math.pi * t / LENGTH))


@CASES.add(
    "hic-sine",
    "HIC of a half sine",
    "cos φ = 0.6 sin φ / φ, HIC = (2 φ T/π) (A sin φ / φ)^2.5",
    f"{PEAK:g} g for {1e3 * LENGTH:g} ms, sampled; the window is searched, not given.",
)
def _hic_sine() -> Answer:
    # The best window is symmetric, and the signal at its ends 0.6 of the mean (Chou and Nyquist).
    half = brentq(lambda x: math.cos(x) - 0.6 * math.sin(x) / x, 0.1, 1.5, xtol=1e-15)
    width, mean = 2.0 * half * LENGTH / math.pi, PEAK * math.sin(half) / half
    exact = width * mean**2.5
    t, a = _half_sine(2000)
    result = criteria.hic(a, t)

    def error(step: float) -> float:
        return abs(criteria.hic(*_half_sine(round(LENGTH / step))[::-1]).value / exact - 1.0)

    return Answer(
        (
            relative("HIC15, 2000 samples", result.value, exact, 1e-6),
            relative("length of the window, s", result.end - result.start, width, 1e-4),
        ),
        _window(t, a, result.start, result.end),
        order_of("HIC, in the time between samples", LENGTH / 100, error),
    )


def _window(t: FloatArray, a: FloatArray, start: float, end: float) -> Drawing:
    """Return a drawing of a signal, g over s, with the window from `start` to `end` shaded."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        axes.plot(1e3 * t, a, color=INK, lw=1.2)
        on = (t >= start) & (t <= end)
        axes.fill_between(1e3 * t[on], a[on], color=LINES[0], alpha=0.3, label="window")
        axes.set(xlabel="t, ms", ylabel="a, g")
        axes.legend()

    return draw


@CASES.add(
    "hic-lines",
    "HIC of a triangle and of a constant",
    "triangle: window 4/7 of the base, HIC = (4 T/7) (5 A/7)^2.5; constant: T₁₅ A^2.5",
    "Straight lines between samples are exact.",
)
def _hic_lines() -> Answer:
    base, share = 0.02, 4.0 / 7.0
    t, a = np.array([0.0, base / 2, base]), np.array([0.0, PEAK, 0.0])
    result = criteria.hic(a, t)
    triangle = share * base * (PEAK * (1.0 - 0.5 * share)) ** 2.5
    level = np.full(11, 80.0), np.linspace(0.0, 0.1, 11)
    checks = (
        relative("triangle, HIC15", result.value, triangle, EXACT),
        relative("triangle, its window, s", result.end - result.start, share * base, 1e-9),
        relative("constant 80 g, HIC15", criteria.hic(*level).value, 0.015 * 80.0**2.5, EXACT),
        relative(
            "constant 80 g, HIC36", criteria.hic(*level, 0.036).value, 0.036 * 80.0**2.5, EXACT
        ),
    )
    fine = np.linspace(0.0, base, 801)
    return Answer(checks, _window(fine, np.interp(fine, t, a), result.start, result.end))


@CASES.add(
    "clip",
    "3 ms value",
    "triangle: A (1 − 3 ms/T); half sine: A cos(π · 3 ms / 2 T)",
    "The largest level that the signal stays above for 3 ms.",
)
def _clip() -> Answer:
    base = 0.02
    t, a = np.array([0.0, base / 2, base]), np.array([0.0, PEAK, 0.0])
    triangle = criteria.clip(a, t)
    sine = criteria.clip(*_half_sine(4000)[::-1])
    checks = (
        relative("triangle, 3 ms value", triangle.value, PEAK * (1.0 - 0.003 / base), EXACT),
        relative(
            "half sine, 3 ms value", sine.value, PEAK * math.cos(0.5 * math.pi * 0.003 / LENGTH),
            1e-6,
        ),
    )  # fmt: skip
    times, values = _half_sine(400)
    return Answer(checks, _window(times, values, sine.start, sine.end))


def _gain(cls: int, frequency: float) -> float:
    """Return the gain of filter CFC `cls` for a long sine of `frequency`, Hz.

    The amplitude is fitted by least squares to the middle third of 60 periods. There are a thousand
    samples in a period of the corner frequency, where the digital filter of the standard shifts
    frequencies by some parts in 10⁵.
    """
    dt = 1e-3 * 0.6 / cls
    count = round(20.0 / frequency / dt)
    t = dt * np.arange(3 * count)
    inner = slice(count, 2 * count)
    phase = 2.0 * math.pi * frequency * t
    passed = criteria.cfc(np.sin(phase), dt, cls)[inner]
    basis = np.column_stack([np.sin(phase), np.cos(phase)])[inner]
    return float(np.hypot(*np.linalg.lstsq(basis, passed, rcond=None)[0]))


@CASES.add(
    "cfc",
    "Filters CFC 60 to 1000 at their corner",
    "|H(CFC / 0.6)| = 1/√2 (SAE J211-1)",
    "A long sine, 1000 samples a period, through each filter; amplitude by least squares.",
)
def _cfc() -> Answer:
    checks: list[Check] = []
    for cls in (60, 180, 600, 1000):
        corner = cls / 0.6
        checks.append(
            relative(f"CFC {cls}, gain at {corner:.0f} Hz", _gain(cls, corner), 0.5**0.5, 1e-4)
        )
    cls, sample_frequencies = 180, np.array([0.2, 0.5, 1.0, 2.0, 4.0]) * 180 / 0.6
    # Two passes of a Butterworth filter of two poles, its corner at 2.0775 times the class.
    smooth = np.geomspace(0.1, 6.0, 100) * cls / 0.6
    exact = 1.0 / (1.0 + (smooth / (2.0775 * cls)) ** 4)
    gains = np.array([_gain(cls, f) for f in sample_frequencies])
    return Answer(
        tuple(checks),
        comparison(
            ("frequency, Hz", "gain of CFC 180"),
            [("two passes of a Butterworth filter", smooth, exact)],
            [("measured", sample_frequencies, gains)],
        ),
    )
