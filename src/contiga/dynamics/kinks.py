"""Kinks: times of a table at which steps have to end, so that they take all of it into account.

A step sees a load, and where a motion stands, at its two ends, and takes what is between for even.
So it may pass over rows of a table as long as those lie on a line. Whether they do is told by what
lies between line and table, ∫|f − line| dt, against what the table holds there, ∫|f| dt: what all
passed rows together leave out is at most twice the share `PASSED` of ∫|f| dt over the whole table,
however short and high one of its pulses is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from contiga.records import FloatArray

PASSED = 2e-3
SAME_TIME = 1e-9
"""Part of a span below which two times are one."""


def bends_of(times: FloatArray, values: FloatArray) -> FloatArray:
    """Return which `times` (n,) end steps, for a function linear between rows `values` (n, d).

    >>> t = np.arange(6.0)
    >>> bends_of(t, np.array([[0.0], [0.0], [1.0], [2.0], [3.0], [0.0]])).tolist()
    [0.0, 1.0, 4.0, 5.0]
    """
    size, spans = _lengths(values), np.diff(times)

    def apart(first: int, last: int) -> float:
        t, rows = times[first : last + 1], values[first : last + 1]
        part = ((t - t[0]) / (t[-1] - t[0]))[:, None]
        off = _lengths(rows - rows[0] - part * (rows[-1] - rows[0]))
        return float(0.5 * (np.diff(t) * (off[1:] + off[:-1])).sum())

    return _kept(times, 0.5 * spans * (size[1:] + size[:-1]), apart)


def jumps_of(times: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the jumps of rates (n − 1, d) that are constant between two times.

    >>> jumps_of(np.arange(4.0), np.array([[2.0], [2.0], [-1.0]])).tolist()
    [0.0, 2.0, 3.0]
    """
    spans = np.diff(times)

    def apart(first: int, last: int) -> float:
        own, rows = spans[first:last, None], rates[first:last]
        mean = (own * rows).sum(axis=0) / (times[last] - times[first])
        return float((own[:, 0] * _lengths(rows - mean)).sum())

    return _kept(times, spans * _lengths(rates), apart)


def united(kinks: Iterable[Iterable[float]], start: float, end: float) -> tuple[float, ...]:
    """Return all kinks between two times, rising, none closer than `SAME_TIME` to another."""
    nearest, kept = SAME_TIME * (end - start), [start]
    for time in sorted({float(t) for some in kinks for t in some}):
        if time > kept[-1] + nearest and time < end - nearest:
            kept.append(time)
    return tuple(kept[1:])


def _lengths(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt((rows * rows).sum(axis=1)))


def _kept(times: FloatArray, held: FloatArray, apart: Callable[[int, int], float]) -> FloatArray:
    """Rows one after the other, each as far from the one before as a line between is right.

    `held` (n − 1,) is ∫|f| dt of each piece, `apart` ∫|f − line| dt between two rows.
    """
    if len(times) < 3:
        return times
    total = np.concatenate([[0.0], np.cumsum(held)])
    even = total[-1] / (times[-1] - times[0])

    def near(first: int, last: int) -> bool:
        if last >= len(times):
            return False
        change = max(total[last] - total[first], even * (times[last] - times[first]))
        return bool(apart(first, last) <= PASSED * change)

    kept = [0]
    while kept[-1] < len(times) - 1:
        first, step = kept[-1], 1
        good = first + 1
        while near(first, good + step):
            good, step = good + step, 2 * step
        while step := step // 2:
            if near(first, good + step):
                good += step
        kept.append(good)
    return np.asarray(times[kept])
