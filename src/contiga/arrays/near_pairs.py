"""Pairs of near points, without a tree, for few pairs among many points."""

from __future__ import annotations

import numpy as np

from contiga.records import FloatArray, IndexArray

_MIX = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], np.uint64)
"""Odd factors that hash a cell's three numbers; the distances resolve collisions."""
_NEIGHBOURS = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)]
_HALF_NEIGHBOURS = [step for step in _NEIGHBOURS if step > (0, 0, 0)]
"""Half of the cells around a cell, so that each pair of cells occurs once."""


def near_pairs(points: FloatArray, reach: float) -> IndexArray:
    """Return the sorted pairs (m, 2), i < j, of points (n, 3) at most `reach` > 0 apart.

    Points are hashed by cells as long as the reach, and the pairs of neighbouring cells measured.
    The result is that of `scipy.spatial.cKDTree.query_pairs`, which takes longer to load than
    numba.

    >>> near_pairs(np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.9, 0.0]]), 1.0)
    array([[0, 2]])
    """
    if len(points) < 2:
        return np.zeros((0, 2), np.int64)
    cell = np.floor((points - points.min(axis=0)) / reach).astype(np.int64)
    key = _cell_keys(cell)
    order = np.argsort(key, kind="stable")
    sorted_keys = key[order]
    rows = np.arange(len(points))
    after = np.searchsorted(sorted_keys, key[order], side="right")
    parts = [_ranges(order, order, rows + 1, after)]
    for step in _HALF_NEIGHBOURS:
        neighbour = _cell_keys(cell + np.array(step))
        low = np.searchsorted(sorted_keys, neighbour, side="left")
        high = np.searchsorted(sorted_keys, neighbour, side="right")
        parts.append(_ranges(rows, order, low, high))
    pairs = np.concatenate(parts)
    distance = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = np.sort(pairs[distance <= reach], axis=1)
    return np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0)


def _cell_keys(cell: IndexArray) -> np.ndarray:
    """Return (n,) hash of each cell (n, 3); different cells rarely share one."""
    return (cell.astype(np.uint64) * _MIX).sum(axis=1, dtype=np.uint64)


def _ranges(rows: IndexArray, order: IndexArray, low: IndexArray, high: IndexArray) -> IndexArray:
    """Return the pairs of rows[k] with each of order[low[k]:high[k]]."""
    count = np.maximum(high - low, 0)
    start = np.cumsum(count) - count
    at = np.repeat(low - start, count) + np.arange(count.sum())
    return np.stack([np.repeat(rows, count), order[at]], axis=1)
