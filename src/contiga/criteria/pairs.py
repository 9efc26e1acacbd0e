"""Find by branch and bound the pairs of pieces on which the best window starts and ends.

Blocks of 2^k pieces are paired; a pair of blocks is left out, with all its pairs of pieces, if no
window between them can exceed the best value, or if none can have 0.6 of its mean at both ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.criteria.samples import Line
from contiga.records import FloatArray, IndexArray

BATCH = 1 << 17
"""Number of pairs that are examined together."""
END_TOL = 1e-9
"""Tolerance of the conditions at the ends, over the largest value: rounding."""
BOUND_TOL = 1e-13
"""Relative amount by which a bound must exceed the best value: rounding."""


class _Blocks(NamedTuple):
    """Blocks of one length."""

    first: IndexArray
    """(b + 1,) first sample of each block, and the last sample."""
    low: FloatArray
    """(b,) smallest value in each."""
    high: FloatArray
    """(b,) largest value in each."""


class Pairs(NamedTuple):
    """Pairs of pieces, and the best window between samples."""

    i: IndexArray
    """(k,) piece that the window starts on."""
    j: IndexArray
    """(k,) piece that it ends on, above `i`."""
    window: tuple[FloatArray, FloatArray]
    """Start and end, (1,) each; (0,) if none exceeds the initial best value."""


def likely_pairs(line: Line, limit: float, best: float) -> Pairs:
    """Return pairs i < j of pieces that may hold the ends of a window above `best`, ≤ `limit` long.

    Windows between first samples of blocks are evaluated on the way and raise `best`; the best of
    them, if it exceeds the given `best`, is returned with the pairs. Pairs stand in any order.
    """
    # Blocks of 1, 2, 4, … pieces, up to one block of all pieces.
    n = len(line.slope)
    low, high = np.minimum(line.a[1:], line.a[:-1]), np.maximum(line.a[1:], line.a[:-1])
    levels, width = [_Blocks(np.arange(n + 1), low, high)], 1
    while width < n:
        width *= 2
        evens = np.arange(0, len(low), 2)
        low, high = np.minimum.reduceat(low, evens), np.maximum.reduceat(high, evens)
        levels.append(_Blocks(np.append(np.arange(0, n, width), n), low, high))
    window = (line.t[:0], line.t[:0])
    root: IndexArray = np.zeros(1, np.int64)
    stack = [(len(levels) - 1, root, root)]
    pairs = []
    i: IndexArray
    j: IndexArray
    while stack:
        level, i, j = stack.pop()
        p, r = levels[level].first[i], levels[level].first[j]
        length = line.t[r] - line.t[p]
        is_allowed = (length > 0.0) & (length <= limit)
        if is_allowed.any():
            p, r = p[is_allowed], r[is_allowed]
            gain = line.area[r] - line.area[p]
            mean = gain / length[is_allowed]
            values = gain * mean * np.sqrt(mean)
            k = int(np.argmax(values))
            if values[k] > best:
                best, window = float(values[k]), (line.t[p[k : k + 1]], line.t[r[k : k + 1]])
        is_open = _may_exceed(line, levels[level], i, j, limit, best)
        i, j = i[is_open], j[is_open]
        if level == 0:
            pairs.append((i[i < j], j[i < j]))
            continue
        # pairs of halves, the first not after the second
        i = np.repeat(2 * i, 4) + np.tile([0, 0, 1, 1], len(i))
        j = np.repeat(2 * j, 4) + np.tile([0, 1, 0, 1], len(j))
        is_pair = (i <= j) & (j < len(levels[level - 1].low))
        i, j = i[is_pair], j[is_pair]
        for k in range(0, len(i), BATCH):
            stack.append((level - 1, i[k : k + BATCH], j[k : k + BATCH]))
    if not pairs:
        return Pairs(root[:0], root[:0], window)
    i, j = (np.concatenate(column) for column in zip(*pairs, strict=True))
    return Pairs(i, j, window)


def _may_exceed(
    line: Line, blocks: _Blocks, i: IndexArray, j: IndexArray, limit: float, best: float
) -> IndexArray:
    """Return a mask (k,) of the pairs i ≤ j of blocks between which a window may exceed `best`.

    True if the blocks are nearer than `limit`, an upper bound of the value exceeds `best`, and some
    value that both blocks take lies between the bounds of 0.6 of the mean.
    """
    p, q, r, s = blocks.first[i], blocks.first[i + 1], blocks.first[j], blocks.first[j + 1]
    shortest = np.maximum(line.t[r] - line.t[q], 0.0)
    longest = np.minimum(line.t[s] - line.t[p], limit)
    # Bounds of the mean: the largest value for adjacent blocks, the gain for others.
    top = float(line.a.max())
    peak = np.where(j <= i + 1, np.maximum(blocks.high[i], blocks.high[j]), top)
    gain = np.minimum(line.area[s] - line.area[p], peak * longest)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.fmin(gain / shortest, peak)
        min_mean = np.maximum(line.area[r] - line.area[q], 0.0) / (line.t[s] - line.t[p])
    bound = gain * mean * np.sqrt(mean)
    low = np.maximum(np.maximum(blocks.low[i], blocks.low[j]), 0.6 * min_mean)
    high = np.minimum(np.minimum(blocks.high[i], blocks.high[j]), 0.6 * mean)
    return np.asarray(
        (shortest < limit) & (bound > best * (1.0 + BOUND_TOL)) & (low <= high + END_TOL * top)
    )
