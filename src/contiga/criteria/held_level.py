"""The level that a signal holds for a time: the 3 ms value."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.layout import positive
from contiga.criteria.samples import Line, checked_resultant, line_through
from contiga.errors import InputError
from contiga.records import FloatArray

ROUNDING = 1e-9
"""Relative: 30 steps of 0.1 ms are as long as 3 ms, whatever times are rounded to."""


class Clip(NamedTuple):
    """The largest level that is held, and from when to when."""

    value: float
    """In the unit of the signal."""
    start: float
    """Seconds; where the signal first reaches the level of the longest time above it, or, with
    `cumulative`, of the first."""
    end: float
    """Seconds; where it falls below it again, of the last with `cumulative`."""


class _Runs(NamedTuple):
    """Stretches of time in which the signal is at a level or above."""

    start: FloatArray
    end: FloatArray

    def held(self, cumulative: bool) -> float:
        """Return how long the level is held: the longest stretch, or all together."""
        lengths = self.end - self.start
        if len(lengths) == 0:
            return 0.0
        return float(lengths.sum() if cumulative else lengths.max())


def clip(
    a_g: ArrayLike, t_s: ArrayLike, duration: float = 0.003, *, cumulative: bool = False
) -> Clip:
    """The largest level that a resultant does not fall below for `duration` (the 3 ms value).

    Exact for the straight line between samples: the time above a level is a straight line of the
    level, too, from the value of one sample to that of the next larger.

    Parameters
    ----------
    a_g : (n,) resultant acceleration, in g or any unit, filtered
    t_s : (n,) times in seconds, rising, any steps
    duration : seconds
    cumulative : all times above the level count together, not the longest only

    Returns
    -------
    Clip
        the level, and from when to when it is held

    Raises
    ------
    InputError
        Lengths differ, times do not rise, a value is negative or not finite, the duration is not
        positive, or the signal is shorter.

    >>> clip([0.0, 60.0, 0.0], [0.0, 0.5, 1.0], duration=0.5)
    Clip(value=30.0, start=0.25, end=0.75)
    """
    a, t = checked_resultant(a_g, t_s, "clip")
    wanted = positive(duration, "clip, duration")
    whole = float(t[-1] - t[0])
    if whole < wanted * (1.0 - ROUNDING):
        raise InputError(
            "the signal is shorter than the time that a level is to be held for",
            where="clip, t_s",
            found=whole,
            allowed=f"{duration:g} s or more",
            remedy="Times are in seconds",
        )
    level, runs = _highest(line_through(a, t), wanted, cumulative)
    if cumulative:
        return Clip(level, float(runs.start[0]), float(runs.end[-1]))
    k = int(np.argmax(runs.end - runs.start))
    return Clip(level, float(runs.start[k]), float(runs.end[k]))


def _highest(line: Line, wanted: float, cumulative: bool) -> tuple[float, _Runs]:
    """The largest level that is held for `wanted`, and the times above it."""
    levels = np.unique(line.a)
    low, high = 0, len(levels)
    while high - low > 1:
        middle = (low + high) // 2
        runs = _runs(line, line.a >= levels[middle], levels[middle])
        low, high = (middle, high) if runs.held(cumulative) >= wanted else (low, middle)
    level = float(levels[low])
    if high < len(levels):
        # Above this level, up to the next, the same samples are above.
        above = line.a >= levels[high]
        first, last = _runs(line, above, level), _runs(line, above, float(levels[high]))
        if first.held(cumulative) > wanted:
            level += _share(first, last, wanted, cumulative) * float(levels[high] - level)
            return level, _runs(line, above, level)
    return level, _runs(line, line.a >= level, level)


def _share(first: _Runs, last: _Runs, wanted: float, cumulative: bool) -> float:
    """Return how far one may go from `first` to `last` until no more than `wanted` is held."""
    one, other = first.end - first.start, last.end - last.start
    if cumulative:
        one, other = one.sum(keepdims=True), other.sum(keepdims=True)
    long = one >= wanted
    return float(((one - wanted)[long] / (one - other)[long]).max())


def _runs(line: Line, above: NDArray[np.bool_], level: float) -> _Runs:
    """Stretches around the samples that are `above`, to where the signal is at `level`."""
    change = np.diff(np.concatenate([[False], above, [False]]).astype(np.int8))
    first, last = np.flatnonzero(change == 1), np.flatnonzero(change == -1) - 1
    start, end = line.t[first].copy(), line.t[last].copy()
    rises, falls = first > 0, last < len(line.t) - 1
    for times, samples, rows, beside in ((start, first, rises, -1), (end, last, falls, 1)):
        inside = samples[rows]
        outside = inside + beside
        a, b = line.a[inside], line.a[outside]
        share = (a - level) / (a - b)
        times[rows] += share * (line.t[outside] - line.t[inside])
    return _Runs(start, end)
