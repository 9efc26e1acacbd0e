"""Measure how near points are to a surface, which of them is nearest, and which lie inside.

A point lies inside a closed surface by its side of it. It lies inside an open one where its foot is
within a face, it is behind that, and no deeper than is asked about. Of all others, those past a
border of an open surface among them, the distance counts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contiga.masters.protocol import Surface
from contiga.records import FloatArray, IndexArray, IntArray, Projection, empty_projection
from contiga.statuses import Status

# Points looked at at once, the likeliest first.
_BLOCK = 64


class Nearest(NamedTuple):
    """The point that is nearest to a surface, or deepest inside."""

    gap: float
    """Negative inside; infinite if no point has a foot."""
    row: int
    bounds: FloatArray
    """(n,) lower bounds of the gaps of the rows that were asked about, zero of others."""


def nearest(
    surface: Surface,
    p_B: FloatArray,
    rows: IntArray,
    *,
    depth: float | None = None,
    share: float = 0.0,
) -> Nearest:
    """The one of p_B[rows] whose gap is least.

    Parameters
    ----------
    surface : the searched surface
    p_B : (n, 3), finite at `rows`, frame of the surface
    rows : (k,), at least one
    depth : how deep behind an open surface points count as inside, length; None: nothing counts as
        inside, and gaps are distances
    share : part of the gap by which another may be less; far from a surface many nearly are
    """
    bounds = lower_bounds(surface, p_B, rows, depth)

    def gaps(asked: IndexArray) -> FloatArray:
        return gaps_of(surface, p_B[asked], depth)[0]

    gap, at = least(bounds[rows], lambda k: gaps(rows[k]), share)
    return Nearest(gap, int(rows[at]), bounds)


def least(
    bounds: FloatArray, gaps: Callable[[IndexArray], FloatArray], share: float = 0.0
) -> tuple[float, int]:
    """The least of many gaps and its row, by their lower bounds (n,): few are worked out.

    `gaps` gives those of the rows it is asked for, infinite where there is none. Others may be less
    by a `share` of it.
    """
    order = np.argsort(bounds, kind="stable")
    best, row, begin = np.inf, int(order[0]), 0
    # Those of which nothing is known are all looked at, whatever the others are.
    count = max(int(np.count_nonzero(bounds == -np.inf)), _BLOCK)
    enough = np.inf
    while begin < len(order) and bounds[order[begin]] < enough:
        block = order[begin : begin + count]
        gap = gaps(block)
        k = int(gap.argmin())
        if gap[k] < best:
            best, row = float(gap[k]), int(block[k])
            enough = best - share * abs(best)
        begin, count = begin + count, _BLOCK
    return best, row


def gaps_of(
    surface: Surface, p_B: FloatArray, depth: float | None
) -> tuple[FloatArray, Projection]:
    """Gaps (n,) of points (n, 3), infinite without a foot, and their feet; `depth` as above."""
    feet = empty_projection(len(p_B))
    rows = np.arange(len(p_B), dtype=np.int32)
    surface.closest(np.ascontiguousarray(p_B), rows, feet)
    away = np.where(np.isfinite(feet.gap), np.abs(feet.gap), np.inf)
    if depth is None:
        return away, feet
    inside = feet.gap < 0.0
    if not surface.closed:
        inside &= (feet.status == Status.OK) & (away <= depth)
    return np.where(inside, -away, away), feet


def lower_bounds(
    surface: Surface, p_B: FloatArray, rows: IntArray, depth: float | None
) -> FloatArray:
    """Return lower bounds (n,) of the gaps of p_B[rows]; `depth` is that of `nearest`."""
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
