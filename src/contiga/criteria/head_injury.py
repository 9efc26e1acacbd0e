"""The head injury criterion: the largest over all windows, not only those between samples."""

from __future__ import annotations

import math
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import positive
from contiga.criteria.pairs import likely_pairs
from contiga.criteria.samples import Line, checked_resultant, line_through
from contiga.errors import InputError
from contiga.records import FloatArray, IndexArray

_value = attrgetter("value")


class HIC(NamedTuple):
    """The head injury criterion and the window that has it."""

    value: float
    """In s · g^2.5; by convention the unit is not written."""
    start: float
    """Seconds."""
    end: float
    """Seconds."""


def hic(a_g: ArrayLike, t_s: ArrayLike, window: float = 0.015) -> HIC:
    """Head injury criterion: the largest ``(t2 − t1) · (mean of a from t1 to t2)^2.5``.

    `a` is the straight line between samples, and the maximum over all t2 − t1 ≤ `window` is found
    exactly, with ends between samples too. In a largest window shorter than `window`
    ``a(t1) = a(t2) = 0.6 · mean`` (Chou and Nyquist, SAE 740082) wherever an end is none of the
    signal's. On a pair of pieces that is one quadratic equation; pairs whose bound is below what
    is known already, or that cannot have such ends, are left out in blocks.

    Parameters
    ----------
    a_g : (n,) resultant acceleration of the head's centre of gravity, in g, filtered (CFC1000)
    t_s : (n,) times in seconds, rising, any steps
    window : seconds; 0.015 is HIC15, 0.036 HIC36, infinity no limit

    Returns
    -------
    HIC
        the value, and start and end of a window that has it

    Raises
    ------
    InputError
        Lengths differ, times do not rise, a value is negative or not finite, the window is not
        positive.

    >>> hic([100.0, 100.0], [0.0, 0.02])
    HIC(value=1500.0, start=0.0, end=0.015)
    """
    a, t = checked_resultant(a_g, t_s, "hic")
    limit = positive(window, "hic, window", finite=False)
    line = line_through(a, t - t[0])
    sorts = (_whole, _as_long_as_allowed, _from_the_start, _to_the_end)
    best = max((_best(line, *windows(line, limit)) for windows in sorts), key=_value)
    pairs = likely_pairs(line, limit, best.value)
    inside = _inside(line, pairs.i, pairs.j, limit)
    # Of windows as good as each other the first stays.
    best = max(best, _best(line, *pairs.window), _best(line, *inside), key=_value)
    return HIC(best.value, best.start + float(t[0]), best.end + float(t[0]))


def hicd(hic: float) -> float:
    """HIC(d) of a free motion headform: ``0.75446 · HIC + 166.4`` (FMVSS 201, S7).

    `hic` is its HIC36.

    Raises
    ------
    InputError
        `hic` is negative or not finite.

    >>> round(hicd(1000.0), 2)
    920.86
    """
    if not (isinstance(hic, int | float | np.number) and math.isfinite(hic) and hic >= 0):
        raise InputError("must be a value of HIC", where="hicd, hic", found=hic, allowed=">= 0")
    return 0.75446 * float(hic) + 166.4


def _best(line: Line, start: FloatArray, end: FloatArray) -> HIC:
    """The first of the largest of windows, which may be none."""
    if len(start) == 0:
        return HIC(0.0, 0.0, 0.0)
    length = end - start
    gain = np.maximum(line.area_at(end) - line.area_at(start), 0.0)
    mean = np.divide(gain, length, out=np.zeros_like(gain), where=length > 0.0)
    values = gain * mean * np.sqrt(mean)
    # Of windows that only rounding tells apart, the first.
    k = int(np.argmax(values >= values.max() * (1.0 - 1e-13)))
    return HIC(float(values[k]), float(start[k]), float(end[k]))


def _whole(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """The whole signal, where it is allowed."""
    last = line.t[-1:]
    return (np.zeros(1), last) if last[0] <= limit else (last[:0], last[:0])


def _as_long_as_allowed(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """Windows of the length `limit`: ends at samples, and where both values are the same.

    Between those the integral over the window is a parabola of its start.
    """
    last = float(line.t[-1]) - limit
    if last <= 0.0:
        return np.zeros(0), np.zeros(0)
    knots = np.concatenate([line.t, line.t - limit, [0.0, last]])
    knots = np.unique(knots[(knots >= 0.0) & (knots <= last)])
    rise = np.interp(knots + limit, line.t, line.a) - np.interp(knots, line.t, line.a)
    first, second = rise[:-1], rise[1:]
    turns = (first > 0.0) & (second < 0.0)
    share = first[turns] / (first[turns] - second[turns])
    between = knots[:-1][turns] + share * np.diff(knots)[turns]
    starts = np.sort(np.concatenate([knots, between]))
    return starts, np.minimum(starts + limit, line.t[-1])


def _from_the_start(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """Windows from the first sample whose last value is 0.6 of the mean."""
    before, a, slope = line.t[:-1], line.a[:-1], line.slope
    tau = _roots(0.7 * slope, 0.4 * a + slope * before, a * before - 0.6 * line.area[:-1])
    ends = (before + np.clip(tau, 0.0, np.diff(line.t)))[_on(tau, np.diff(line.t))]
    ends = ends[ends <= limit]
    return np.zeros(len(ends)), ends


def _to_the_end(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """Windows to the last sample whose first value is 0.6 of the mean."""
    _, ends = _from_the_start(line.reversed(), limit)
    last = line.t[-1]
    return last - ends, np.full(len(ends), last)


def _inside(
    line: Line, i: IndexArray, j: IndexArray, limit: float
) -> tuple[FloatArray, FloatArray]:
    """Windows from piece `i` to piece `j` > i both of whose ends have 0.6 of the mean.

    Of a maximum the first rises and the last falls: the second derivative of log HIC by t1 is
    0.6 / T² − 2.5 a'(t1) / ∫ there. With c = a(t1) = a(t2), 0.6 ∫ − c T = 0 is a quadratic in c.
    """
    proper = (line.slope[i] > 0.0) & (line.slope[j] < 0.0)
    i, j = i[proper], j[proper]
    steps = np.diff(line.t)
    m, n = line.slope[i], line.slope[j]
    low, rise = line.a[i], line.a[j] - line.a[i]
    # Pieces that hardly slope have no root on them: what overflows is left out below.
    # With c = low + x the ends are at x / m and (x − rise) / n on their pieces.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        bend = 1.0 / n - 1.0 / m
        length = line.t[j] - line.t[i] - rise / n
        area = line.area[j] - line.area[i] - (low + 0.5 * rise) * rise / n
        x = _roots(-0.7 * bend, -0.4 * low * bend - length, 0.6 * area - low * length)
        sigma, tau = x / m, (x - rise) / n
    fits = _on(sigma, steps[i]) & _on(tau, steps[j])
    start = (line.t[i] + np.clip(sigma, 0.0, steps[i]))[fits]
    end = (line.t[j] + np.clip(tau, 0.0, steps[j]))[fits]
    allowed = end - start <= limit
    return start[allowed], end[allowed]


def _on(offset: FloatArray, steps: FloatArray) -> IndexArray:
    """Return whether places lie on their pieces, up to rounding; not where they are NaN."""
    with np.errstate(invalid="ignore"):
        return np.asarray((offset >= -1e-6 * steps) & (offset <= (1.0 + 1e-6) * steps))


def _roots(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return (2, n) real roots of a x² + b x + c, NaN where there are none."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        big = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        return np.stack([big / a, c / big])
