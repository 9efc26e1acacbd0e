"""Kinks: times of a table at which steps must end so that no part of the table is lost.

A step uses a load, or a motion, at its two ends, and takes it as linear between them. So it may
skip rows of a table that lie on a line. They do if ∫|f − line| dt between the ends is at most the
share `SKIP_TOL` of ∫|f| dt there, or of its mean over the table. All skipped rows together then
change ∫|f| dt over the table by at most twice that share, however short and high a pulse is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from contiga.records import FloatArray

SKIP_TOL = 2e-3
"""Largest ∫|f − line| dt, over ∫|f| dt, of rows that a step may skip."""
TIME_TOL = 1e-9
"""Difference, over the length of a run, below which two times count as one."""


def bends_of(times: FloatArray, values: FloatArray) -> FloatArray:
    """Return the `times` (k,) that end steps, for a function linear between rows `values` (n, d).

    The first and the last are among them; rows that a line replaces within `SKIP_TOL` are not.

    >>> t = np.arange(6.0)
    >>> bends_of(t, np.array([[0.0], [0.0], [1.0], [2.0], [3.0], [0.0]])).tolist()
    [0.0, 1.0, 4.0, 5.0]
    """
    norms, spans = _norms(values), np.diff(times)

    def deviation(first: int, last: int) -> float:
        t, rows = times[first : last + 1], values[first : last + 1]
        share = ((t - t[0]) / (t[-1] - t[0]))[:, None]
        errors = _norms(rows - rows[0] - share * (rows[-1] - rows[0]))
        return float(0.5 * (np.diff(t) * (errors[1:] + errors[:-1])).sum())

    return _thinned(times, 0.5 * spans * (norms[1:] + norms[:-1]), deviation)


def jumps_of(times: FloatArray, rates: FloatArray) -> FloatArray:
    """Return the times (k,) that end steps, for rates (n − 1, d) constant between `times` (n,).

    The first and the last are among them; rows that a mean rate replaces within `SKIP_TOL` are not.

    >>> jumps_of(np.arange(4.0), np.array([[2.0], [2.0], [-1.0]])).tolist()
    [0.0, 2.0, 3.0]
    """
    spans = np.diff(times)

    def deviation(first: int, last: int) -> float:
        lengths, rows = spans[first:last, None], rates[first:last]
        mean = (lengths * rows).sum(axis=0) / (times[last] - times[first])
        return float((lengths[:, 0] * _norms(rows - mean)).sum())

    return _thinned(times, spans * _norms(rates), deviation)


def merge_kinks(kinks: Iterable[Iterable[float]], start: float, end: float) -> tuple[float, ...]:
    """Return all kinks strictly between two times, rising, the first of those that nearly agree.

    Kinks closer than `TIME_TOL` of the span to the one before, or to an end, are dropped.
    """
    tol, times = TIME_TOL * (end - start), [start]
    for time in sorted({float(t) for source in kinks for t in source}):
        if time > times[-1] + tol and time < end - tol:
            times.append(time)
    return tuple(times[1:])


def _norms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt((rows * rows).sum(axis=1)))


def _thinned(
    times: FloatArray, integrals: FloatArray, deviation: Callable[[int, int], float]
) -> FloatArray:
    """Return the times (k,) of the rows that remain if each skips as many as a line may replace.

    The number skipped is searched by doubling and halving, so that a longer straight stretch may be
    missed. `integrals` (n − 1,) are ∫|f| dt of the pieces; `deviation` returns ∫|f − line| dt
    between two rows, by their numbers. Fewer than three times are returned themselves.
    """
    if len(times) < 3:
        return times
    total = np.concatenate([[0.0], np.cumsum(integrals)])
    mean = total[-1] / (times[-1] - times[0])

    def is_straight(first: int, last: int) -> bool:
        if last >= len(times):
            return False
        scale = max(total[last] - total[first], mean * (times[last] - times[first]))
        return bool(deviation(first, last) <= SKIP_TOL * scale)

    rows = [0]
    while rows[-1] < len(times) - 1:
        first, step = rows[-1], 1
        last = first + 1
        while is_straight(first, last + step):
            last, step = last + step, 2 * step
        while step := step // 2:
            if is_straight(first, last + step):
                last += step
        rows.append(last)
    return np.asarray(times[rows])
