"""The level that a signal holds for a time: the 3 ms value."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import positive
from contiga.criteria.samples import Line, checked_resultant, line_through
from contiga.errors import InputError
from contiga.records import FloatArray

DURATION_TOL = 1e-9
"""Relative tolerance of durations: 30 steps of 0.1 ms are as long as 3 ms in spite of rounding."""


class Clip(NamedTuple):
    """The largest level that is held, and its time."""

    value: float
    """Level in the unit of the signal."""
    start: float
    """Start of the longest stretch above the level, of the first with `cumulative`; seconds."""
    end: float
    """End of the longest stretch above the level, of the last with `cumulative`; seconds."""


class _Runs(NamedTuple):
    """Stretches of time in which the signal is at a level or above."""

    start: FloatArray
    end: FloatArray

    def duration(self, cumulative: bool) -> float:
        """Return the length of the longest stretch, or of all together; 0 without stretches."""
        lengths = self.end - self.start
        if len(lengths) == 0:
            return 0.0
        return float(lengths.sum() if cumulative else lengths.max())


def clip(
    a_g: ArrayLike, t_s: ArrayLike, duration: float = 0.003, *, cumulative: bool = False
) -> Clip:
    """Return the largest level that a resultant does not fall below for `duration` (3 ms value).

    Exact for the straight line between samples: the time above a level is a linear function of the
    level between the values of two samples. A signal that is shorter than `duration` by rounding
    only (1e-9) counts as long enough, and its smallest value is held.

    Parameters
    ----------
    a_g : (n,) resultant acceleration, in g or any unit, filtered
    t_s : (n,) times in seconds, rising, any steps
    duration : seconds
    cumulative : all times above the level count together, not the longest only

    Returns
    -------
    Clip
        the level, and start and end of the first of the longest stretches above it; with
        `cumulative`, start of the first stretch and end of the last

    Raises
    ------
    InputError
        Lengths differ, times do not rise, a value is negative or not finite, the duration is not
        positive, or the signal is shorter.

    >>> clip([0.0, 60.0, 0.0], [0.0, 0.5, 1.0], duration=0.5)
    Clip(value=30.0, start=0.25, end=0.75)
    """
    a, t = checked_resultant(a_g, t_s, "clip")
    duration = positive(duration, "clip, duration")
    length = float(t[-1] - t[0])
    if length < duration * (1.0 - DURATION_TOL):
        raise InputError(
            "the signal is shorter than the time that a level is to be held for",
            where="clip, t_s",
            found=length,
            allowed=f"{duration:g} s or more",
            remedy="Times are in seconds",
        )
    line = line_through(a, t)
    # bisection for the highest value of a sample that is held
    levels = np.unique(line.a)
    low, high = 0, len(levels)
    while high - low > 1:
        middle = (low + high) // 2
        runs = _runs(line, line.a >= levels[middle], levels[middle])
        is_held = runs.duration(cumulative) >= duration
        low, high = (middle, high) if is_held else (low, middle)
    level = float(levels[low])
    is_above = line.a >= level
    if high < len(levels):
        # The same samples are above all levels from this one to the next.
        is_above_next = line.a >= levels[high]
        lower_runs = _runs(line, is_above_next, level)
        if lower_runs.duration(cumulative) > duration:
            is_above = is_above_next
            upper_runs = _runs(line, is_above, float(levels[high]))
            lower, upper = lower_runs.end - lower_runs.start, upper_runs.end - upper_runs.start
            if cumulative:
                lower, upper = lower.sum(keepdims=True), upper.sum(keepdims=True)
            is_long = lower >= duration
            share = float(((lower - duration)[is_long] / (lower - upper)[is_long]).max())
            level += share * float(levels[high] - level)
    runs = _runs(line, is_above, level)
    if cumulative:
        return Clip(level, float(runs.start[0]), float(runs.end[-1]))
    k = int(np.argmax(runs.end - runs.start))
    return Clip(level, float(runs.start[k]), float(runs.end[k]))


def _runs(line: Line, is_above: NDArray[np.bool_], level: float) -> _Runs:
    """Return starts and ends (k,) of the stretches around samples `is_above` (n,), at `level`.

    A stretch starts and ends where the line from its outermost sample to the next one, which is not
    above, crosses `level`, or at an end of the signal.
    """
    change = np.diff(np.concatenate([[False], is_above, [False]]).astype(np.int8))
    first, last = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
    start, end = line.t[first].copy(), line.t[last].copy()
    rises, falls = first > 0, last < len(line.t) - 1
    for times, samples, rows, step in ((start, first, rises, -1), (end, last, falls, 1)):
        inside = samples[rows]
        outside = inside + step
        a, b = line.a[inside], line.a[outside]
        share = (a - level) / (a - b)
        times[rows] += share * (line.t[outside] - line.t[inside])
    return _Runs(start, end)
