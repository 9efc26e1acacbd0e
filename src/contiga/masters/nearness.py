"""Gaps of points to a surface, and the point with the smallest gap.

A point is inside a closed surface if it is on its inner side. A point is inside an open surface if
its foot lies within a face, the point is behind that face, and no deeper than a given depth. The
gap of any other point, such as one past a border of an open surface, is its distance.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contiga.masters.protocol import Surface
from contiga.records import FloatArray, IndexArray, IntArray, Projection, empty_projection
from contiga.statuses import Status

# Number of points whose gaps are computed together, the likeliest first.
_BLOCK_SIZE = 64


class Nearest(NamedTuple):
    """The point that is nearest to a surface, or deepest inside."""

    gap: float
    """Negative inside; infinite if no point has a foot."""
    row: int
    bounds: FloatArray
    """(n,) lower bounds of the gaps of the given rows, zero for others."""


def nearest(
    surface: Surface,
    p_B: FloatArray,
    rows: IntArray,
    *,
    depth: float | None = None,
    share: float = 0.0,
) -> Nearest:
    """Return the point of p_B[rows] with the smallest gap, and lower bounds of all gaps.

    Parameters
    ----------
    surface : the searched surface
    p_B : (n, 3), finite at `rows`, frame of the surface
    rows : (k,), at least one
    depth : largest depth behind an open surface at which points count as inside, length; None: no
        point counts as inside, and gaps are distances
    share : tolerance, as a share of the gap: far from a surface many gaps are nearly the smallest
    """
    bounds = lower_bounds(surface, p_B, rows, depth)
    gap, k = smallest_gap(
        bounds[rows], lambda k: gaps_and_feet(surface, p_B[rows[k]], depth)[0], share
    )
    return Nearest(gap, int(rows[k]), bounds)


def smallest_gap(
    bounds: FloatArray, gaps: Callable[[IndexArray], FloatArray], share: float = 0.0
) -> tuple[float, int]:
    """Return the smallest of many gaps and its row; lower bounds (n,) save most evaluations.

    `gaps` returns the gaps of some rows, infinite for points without a foot. Other gaps may be
    smaller than the result by a `share` of it. Of equal gaps the one with the least bound counts;
    without any foot the gap is infinite.
    """
    order = np.argsort(bounds, kind="stable")
    best, row, begin = np.inf, int(order[0]), 0
    # Every row without a bound has to be evaluated.
    count = max(int(np.count_nonzero(bounds == -np.inf)), _BLOCK_SIZE)
    cutoff = np.inf
    while begin < len(order) and bounds[order[begin]] < cutoff:
        block = order[begin : begin + count]
        gap = gaps(block)
        k = int(gap.argmin())
        if gap[k] < best:
            best, row = float(gap[k]), int(block[k])
            cutoff = best - share * abs(best)
        begin, count = begin + count, _BLOCK_SIZE
    return best, row


def gaps_and_feet(
    surface: Surface, p_B: FloatArray, depth: float | None
) -> tuple[FloatArray, Projection]:
    """Return gaps (n,) of points (n, 3), infinite without a foot, and feet; `depth`: see `nearest`.

    A gap is negative inside, and never if `depth` is None.
    """
    feet = empty_projection(len(p_B))
    rows = np.arange(len(p_B), dtype=np.int32)
    surface.closest(np.ascontiguousarray(p_B), rows, feet)
    distance = np.where(np.isfinite(feet.gap), np.abs(feet.gap), np.inf)
    if depth is None:
        return distance, feet
    is_inside = feet.gap < 0.0
    if not surface.closed:
        is_inside &= (feet.status == Status.OK) & (distance <= depth)
    return np.where(is_inside, -distance, distance), feet


def lower_bounds(
    surface: Surface, p_B: FloatArray, rows: IntArray, depth: float | None
) -> FloatArray:
    """Return lower bounds (n,) of the gaps of p_B[rows], zero for other points.

    They are −∞ for points that may be inside; `depth` is as for `nearest`.
    """
    bounds = np.zeros(len(p_B))
    surface.safe_distance(p_B, rows, bounds)
    if depth is None:
        return bounds
    if surface.closed:
        side, _ = surface.sides(p_B, rows)
        bounds[rows[side <= 0]] = -np.inf
    else:
        bounds[rows[bounds[rows] <= depth]] = -np.inf
    return bounds
