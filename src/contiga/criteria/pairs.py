"""Find by branch and bound the pairs of pieces on which the best window starts and ends.

Blocks of 2^k pieces are paired; a pair of blocks is left out, with all pairs of pieces in it, when
no window from the one to the other can be better than the best known, or when none can have 0.6 of
its mean at both ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.criteria.samples import Line
from contiga.records import FloatArray, IndexArray

BATCH = 1 << 17
"""Pairs that are looked at together."""
SLACK = 1e-9
"""Relative to the largest value: rounding of the conditions at the ends."""
NO_BETTER = 1e-13
"""Relative: a bound that is above by rounding only is not above."""


class _Blocks(NamedTuple):
    """Blocks of one length."""

    first: IndexArray
    """(b + 1,) samples that they begin with, and the last sample."""
    low: FloatArray
    """(b,) smallest value in each."""
    high: FloatArray
    """(b,) largest value in each."""


class Pairs(NamedTuple):
    """Pairs of pieces, and the best window between samples that was met on the way."""

    i: IndexArray
    """(k,) piece that the window starts on."""
    j: IndexArray
    """(k,) piece that it ends on, above `i`."""
    window: tuple[FloatArray, FloatArray]
    """Start and end, (1,) each; (0,) where none was better than what was known."""


def likely_pairs(line: Line, limit: float, best: float) -> Pairs:
    """Pairs i < j of pieces that may hold a window better than `best` and shorter than `limit`."""
    levels = _levels(line)
    window = (line.t[:0], line.t[:0])
    every: IndexArray = np.zeros(1, np.int64)
    waiting = [(len(levels) - 1, every, every)]
    pairs = []
    i: IndexArray
    j: IndexArray
    while waiting:
        level, i, j = waiting.pop()
        value, p, r = _between_samples(line, levels[level], i, j, limit)
        if value > best:
            best, window = value, (line.t[p : p + 1], line.t[r : r + 1])
        keep = _may_be_better(line, levels[level], i, j, (limit, best))
        i, j = i[keep], j[keep]
        if level == 0:
            pairs.append((i[i < j], j[i < j]))
            continue
        i, j = _halved(i, j, len(levels[level - 1].low))
        for k in range(0, len(i), BATCH):
            waiting.append((level - 1, i[k : k + BATCH], j[k : k + BATCH]))
    if not pairs:
        return Pairs(every[:0], every[:0], window)
    i, j = (np.concatenate(column) for column in zip(*pairs, strict=True))
    return Pairs(i, j, window)


def _levels(line: Line) -> list[_Blocks]:
    """Blocks of 1, 2, 4, … pieces, up to one of all."""
    n = len(line.slope)
    low, high = np.minimum(line.a[1:], line.a[:-1]), np.maximum(line.a[1:], line.a[:-1])
    levels, width = [], 1
    while True:
        levels.append(_Blocks(np.append(np.arange(0, n, width), n), low, high))
        if width >= n:
            return levels
        pairs = np.arange(0, len(low), 2)
        low, high = np.minimum.reduceat(low, pairs), np.maximum.reduceat(high, pairs)
        width *= 2


def _halved(i: IndexArray, j: IndexArray, count: int) -> tuple[IndexArray, IndexArray]:
    """Pairs of halves of blocks, the first not after the second."""
    ii = np.repeat(2 * i, 4) + np.tile([0, 0, 1, 1], len(i))
    jj = np.repeat(2 * j, 4) + np.tile([0, 1, 0, 1], len(j))
    there = (ii <= jj) & (jj < count)
    return ii[there], jj[there]


def _between_samples(
    line: Line, blocks: _Blocks, i: IndexArray, j: IndexArray, limit: float
) -> tuple[float, int, int]:
    """The best value of windows from the first samples of `i` to those of `j`, and the samples."""
    p, r = blocks.first[i], blocks.first[j]
    length = line.t[r] - line.t[p]
    good = (length > 0.0) & (length <= limit)
    if not good.any():
        return 0.0, 0, 0
    p, r, length = p[good], r[good], length[good]
    gain = line.area[r] - line.area[p]
    mean = gain / length
    values = gain * mean * np.sqrt(mean)
    k = int(np.argmax(values))
    return float(values[k]), int(p[k]), int(r[k])


def _may_be_better(
    line: Line, blocks: _Blocks, i: IndexArray, j: IndexArray, given: tuple[float, float]
) -> IndexArray:
    """Return whether windows from blocks `i` to blocks `j` may be better than the best known."""
    limit, best = given
    p, q, r, s = blocks.first[i], blocks.first[i + 1], blocks.first[j], blocks.first[j + 1]
    shortest = np.maximum(line.t[r] - line.t[q], 0.0)
    longest = np.minimum(line.t[s] - line.t[p], limit)
    # Means are bounded by the largest value of blocks that touch, and by the gain elsewhere.
    top = float(line.a.max())
    peak = np.where(j <= i + 1, np.maximum(blocks.high[i], blocks.high[j]), top)
    gain = np.minimum(line.area[s] - line.area[p], peak * longest)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.fmin(gain / shortest, peak)
        least = np.maximum(line.area[r] - line.area[q], 0.0) / (line.t[s] - line.t[p])
    bound = gain * mean * np.sqrt(mean)
    low = np.maximum(np.maximum(blocks.low[i], blocks.low[j]), 0.6 * least)
    high = np.minimum(np.minimum(blocks.high[i], blocks.high[j]), 0.6 * mean)
    return np.asarray(
        (shortest < limit) & (bound > best * (1.0 + NO_BETTER)) & (low <= high + SLACK * top)
    )
