"""The head injury criterion: the maximum over all windows, not only windows between samples."""

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
    """The head injury criterion and its window."""

    value: float
    """Criterion in s · g^2.5; by convention the unit is not written."""
    start: float
    """Start of the window, seconds."""
    end: float
    """End of the window, seconds."""


def hic(a_g: ArrayLike, t_s: ArrayLike, window: float = 0.015) -> HIC:
    """Return the head injury criterion: the maximum of ``(t2 − t1) · (mean of a)^2.5``.

    The mean is from t1 to t2, and `a` is the straight line between samples. The maximum over all
    t2 − t1 ≤ `window` is exact, with ends between samples too. In a maximum window shorter than
    `window` ``a(t1) = a(t2) = 0.6 · mean`` (Chou and Nyquist, SAE 740082) at each end that is not
    an end of the signal. On a pair of pieces this is one quadratic equation; blocks of pairs whose
    upper bound is below the best value, or that cannot have such ends, are left out. Of several
    windows with the maximum, one as long as `window` or the signal is returned, the earliest such.

    Parameters
    ----------
    a_g : (n,) resultant acceleration of the head's centre of gravity, in g, filtered (CFC1000)
    t_s : (n,) times in seconds, rising, any steps
    window : seconds; 0.015 is HIC15, 0.036 HIC36, infinity no limit

    Returns
    -------
    HIC
        the value, and start and end of its window

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
    end = line.t[-1:]
    full_window = (np.zeros(1), end) if end[0] <= limit else (end[:0], end[:0])
    _, durations = _windows_from_start(line.reversed(), limit)
    windows_to_end = end[0] - durations, np.full(len(durations), end[0])
    border_windows = (
        full_window,
        _windows_of_length(line, limit),
        _windows_from_start(line, limit),
        windows_to_end,
    )
    # of equal windows the first is the maximum
    best = max((_best_window(line, *windows) for windows in border_windows), key=_value)
    pairs = likely_pairs(line, limit, best.value)
    inner_windows = _inner_windows(line, pairs.i, pairs.j, limit)
    candidates = best, _best_window(line, *pairs.window), _best_window(line, *inner_windows)
    best = max(candidates, key=_value)
    return HIC(best.value, best.start + float(t[0]), best.end + float(t[0]))


def hicd(hic: float) -> float:
    """Return HIC(d) of a free motion headform: ``0.75446 · HIC36 + 166.4`` (FMVSS 201, S7).

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


def _best_window(line: Line, start: FloatArray, end: FloatArray) -> HIC:
    """Return the first window whose value is the largest up to rounding; all zero without windows.

    A negative integral by rounding and a window without length count as zero.
    """
    if len(start) == 0:
        return HIC(0.0, 0.0, 0.0)
    length = end - start
    gain = np.maximum(line.area_at(end) - line.area_at(start), 0.0)
    mean = np.divide(gain, length, out=np.zeros_like(gain), where=length > 0.0)
    values = gain * mean * np.sqrt(mean)
    k = int(np.argmax(values >= values.max() * (1.0 - 1e-13)))
    return HIC(float(values[k]), float(start[k]), float(end[k]))


def _windows_of_length(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """Return starts and ends (k,) of windows of length `limit` that may hold the maximum.

    An end is at a sample, or both ends have one value: between samples the integral over the window
    is a parabola of its start. Starts rise; a signal that is not longer than `limit` has none.
    """
    last = float(line.t[-1]) - limit
    if last <= 0.0:
        return np.zeros(0), np.zeros(0)
    knots = np.concatenate([line.t, line.t - limit, [0.0, last]])
    knots = np.unique(knots[(knots >= 0.0) & (knots <= last)])
    rise = np.interp(knots + limit, line.t, line.a) - np.interp(knots, line.t, line.a)
    first, second = rise[:-1], rise[1:]
    has_maximum = (first > 0.0) & (second < 0.0)
    share = first[has_maximum] / (first[has_maximum] - second[has_maximum])
    maxima = knots[:-1][has_maximum] + share * np.diff(knots)[has_maximum]
    starts = np.sort(np.concatenate([knots, maxima]))
    return starts, np.minimum(starts + limit, line.t[-1])


def _windows_from_start(line: Line, limit: float) -> tuple[FloatArray, FloatArray]:
    """Return starts (0) and ends (k,) of windows from the first sample, 0.6 of the mean at the end.

    The first sample is at time 0, and they are at most `limit` long. With an end at t + tau on a
    piece this is a quadratic in tau.
    """
    t, a, slope = line.t[:-1], line.a[:-1], line.slope
    tau = _roots(0.7 * slope, 0.4 * a + slope * t, a * t - 0.6 * line.area[:-1])
    ends = (t + np.clip(tau, 0.0, np.diff(line.t)))[_is_on_piece(tau, np.diff(line.t))]
    ends = ends[ends <= limit]
    return np.zeros(len(ends)), ends


def _inner_windows(
    line: Line, i: IndexArray, j: IndexArray, limit: float
) -> tuple[FloatArray, FloatArray]:
    """Return starts and ends (k,) of windows from piece `i` to `j` > i, 0.6 of the mean at both.

    They are at most `limit` long. At a maximum the first piece rises and the last falls (other
    pairs are left out): the second derivative of log HIC by t1 is 0.6 / T² − 2.5 a'(t1) / ∫. With
    c = a(t1) = a(t2), 0.6 ∫ − c T = 0 is a quadratic in c.
    """
    may_be_maximum = (line.slope[i] > 0.0) & (line.slope[j] < 0.0)
    i, j = i[may_be_maximum], j[may_be_maximum]
    steps = np.diff(line.t)
    m, n = line.slope[i], line.slope[j]
    low, rise = line.a[i], line.a[j] - line.a[i]
    # Nearly flat pieces have no root on them: overflowing values are left out below.
    # With c = low + x the ends are at x / m and (x − rise) / n on their pieces.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        bend = 1.0 / n - 1.0 / m
        length = line.t[j] - line.t[i] - rise / n
        area = line.area[j] - line.area[i] - (low + 0.5 * rise) * rise / n
        x = _roots(-0.7 * bend, -0.4 * low * bend - length, 0.6 * area - low * length)
        sigma, tau = x / m, (x - rise) / n
    is_on = _is_on_piece(sigma, steps[i]) & _is_on_piece(tau, steps[j])
    start = (line.t[i] + np.clip(sigma, 0.0, steps[i]))[is_on]
    end = (line.t[j] + np.clip(tau, 0.0, steps[j]))[is_on]
    is_allowed = end - start <= limit
    return start[is_allowed], end[is_allowed]


def _is_on_piece(offset: FloatArray, steps: FloatArray) -> IndexArray:
    """Return a mask of the offsets on pieces of lengths `steps`, up to rounding; False for NaN."""
    with np.errstate(invalid="ignore"):
        return np.asarray((offset >= -1e-6 * steps) & (offset <= (1.0 + 1e-6) * steps))


def _roots(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Return (2, n) real roots of a x² + b x + c, without cancellation; NaN if there are none.

    Where a = 0, the first is not finite and the second is −c / b.
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        q = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        return np.stack([q / a, c / q])
