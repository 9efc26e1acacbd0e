"""Points that lie near one another, without a tree: few of many do."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray, IndexArray

_MIX = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
"""Odd numbers that make one of a cell's three; cells that share one are told apart by distance."""
_AROUND = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
_AFTER = [step for step in _AROUND if step > (0, 0, 0)]
"""Half of the cells around a cell: of two cells each is around the other."""


def near_pairs(points: FloatArray, reach: float) -> IndexArray:
    """Pairs of points (n, 3) that are at most `reach` > 0 apart: rows (m, 2), i < j, in order.

    By cells as long as the reach. As `scipy.spatial.cKDTree.query_pairs`, which takes longer to
    load than numba.

    >>> near_pairs(np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.9, 0.0]]), 1.0)
    array([[0, 2]])
    """
    if len(points) < 2:
        return np.zeros((0, 2), np.int64)
    cell = np.floor((points - points.min(axis=0)) / reach).astype(np.int64)
    name = _named(cell)
    order = np.argsort(name, kind="stable")
    sorted_names = name[order]
    rows = np.arange(len(points))
    after = np.searchsorted(sorted_names, name[order], side="right")
    parts = [_ranges(order, order, rows + 1, after)]
    for step in _AFTER:
        other = _named(cell + np.array(step))
        low, high = (np.searchsorted(sorted_names, other, side=side) for side in ("left", "right"))
        parts.append(_ranges(rows, order, low, high))
    pairs = np.concatenate(parts)
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = np.sort(pairs[apart <= reach], axis=1)
    return np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)


def _named(cell: IndexArray) -> np.ndarray:
    """Return (n,) a number for each cell (n, 3); that different cells share one is rare."""
    return (cell.astype(np.uint64) * _MIX).sum(axis=1, dtype=np.uint64)


def _ranges(rows: IndexArray, order: IndexArray, low: IndexArray, high: IndexArray) -> IndexArray:
    """Pairs of rows[k] with each of order[low[k]:high[k]]."""
    count = np.maximum(high - low, 0)
    start = np.cumsum(count) - count
    at = np.repeat(low - start, count) + np.arange(count.sum())
    return np.stack([np.repeat(rows, count), order[at]], axis=1)
