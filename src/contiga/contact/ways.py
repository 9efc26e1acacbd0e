"""Ways of points that lie deep: which wall pushes each at its end.

It is the nearest one, as long as that is not opposite: its outward normal makes less than 160° with
the point's guard, which is the normal of the wall that was the nearest one before. Where it is
opposite it does not take over, nor does one that has been nearer all along. The point is then held
by the nearest wall that does not face away from its guard, and the guard stays as it is until the
nearest wall is not opposite to it any more. So the depth is continuous: the distance to all of the
surface, or to walls that stay the same (`docs/theory.md`).

What follows from what stands in `way_nb.answered`, which asks one question after the other. On
exact geometry a kernel answers them at once, elsewhere the surface, for all ways together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths
from contiga.arrays.threads import run_ranges
from contiga.contact.foot_rows import take
from contiga.contact.kernels import way_nb
from contiga.contact.kernels.settle_nb import ANOTHER, OPPOSITE_COSINE, PART
from contiga.contact.search_records import BoolArray, Limits, Options
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.pointer_records import pass_by_pointer
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
    rows_of,
)

WIDEST = 2.0**-6
"""Share of a way that a part of it is at least, where it is not halved."""
WAYS = 8
"""Ways that a thread goes along at once."""


@pass_by_pointer
class Ways(NamedTuple):
    """Ways of n points, one row each; what changes as they are gone along, and what is asked."""

    start: FloatArray
    """(n, 3) with the next, body frame."""
    end: FloatArray
    length: FloatArray
    """(n,)"""
    last: Projection
    """The closest points at the ends."""
    longest: FloatArray
    """(n,) share of a way that a part of it may be."""
    guard: FloatArray
    """(n, 3) zero where there is none."""
    depth: FloatArray
    """(n,) how deep points are; −inf in a closed body where they came in."""
    opposed: BoolArray
    """(n,) whether another wall than the nearest pushes."""
    patch: IntArray
    """(n,) with (n, 2), the feet; patch −1 where it is not known."""
    uv: FloatArray
    at: FloatArray
    """(n,) share of a way that has been gone."""
    part: FloatArray
    """(n,) share that is to be gone next,"""
    to: FloatArray
    """(n,) and to where."""
    looks: IntArray
    tries: IntArray
    is_anew: BoolArray
    """(n,) whether a wall was taken that the point did not come to step by step."""
    outcome: ByteArray
    """(n,) how it ended, as `way_nb` counts."""
    asks: ByteArray
    """(n,) what is asked, as `way_nb` counts."""
    point: FloatArray
    """(n, 3) where."""
    floor: FloatArray
    """(n,) no nearer than this are feet that the guard allows,"""
    ceiling: FloatArray
    """(n,) and no farther."""
    from_patch: IntArray
    """(n,) with (n, 2), the wall whose foot is asked for."""
    from_uv: FloatArray
    nearest: Projection
    """Answers: the closest points,"""
    other: Projection
    """the closest ones that the guard allows,"""
    followed: Projection
    """and feet on walls that are asked about."""
    rows: IntArray
    """(n,) 0 to n − 1."""
    within: FloatArray
    """(n,) infinite: nothing is known of how far the surface is."""

    @property
    def feet(self) -> Projection:
        """The feet on the walls that push at the ends."""
        feet = Projection._make(column.copy() for column in self.last)
        opposed = np.flatnonzero(self.opposed)
        take(feet, opposed, rows_of(self.other, opposed), np.ones(len(opposed), np.bool_))
        return feet


class Start(NamedTuple):
    """The state of points where their ways start, one row each; as of `Ways`."""

    guard: FloatArray
    depth: FloatArray
    opposed: BoolArray
    patch: IntArray
    uv: FloatArray


def gone(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    start: Start,
    nearest: Projection,
    options: Options,
) -> Ways:
    """Go the ways of points along `path` = (from, to) to their ends.

    `nearest` are the closest points there. In a closed body points lie inside all along.
    """
    guard, depth, opposed, patch, uv = start
    n, length = len(patch), row_lengths(path[1] - path[0])
    along = np.einsum("ij,ij->i", nearest.normal, guard)
    # A way on which a point comes to another wall may have led past walls between, and so may one
    # at whose end the nearest wall does not hold the point.
    turns = opposed | (nearest.gap > 0.0) | (-nearest.gap < depth - length)
    turns |= (along < ANOTHER) & guard.any(axis=1)
    share = -PART * nearest.gap / np.maximum(length, 1e-300)
    longest = np.where(turns, np.fmax(np.fmin(share, 1.0), WIDEST), 1.0)
    ways = Ways(
        start=np.ascontiguousarray(path[0]),
        end=np.ascontiguousarray(path[1]),
        length=length,
        last=nearest,
        longest=np.asarray(longest),
        guard=guard.copy(),
        depth=depth.copy(),
        opposed=opposed.copy(),
        patch=patch.astype(np.int32),
        uv=uv.copy(),
        at=np.zeros(n),
        part=np.array(longest),
        to=np.zeros(n),
        looks=np.zeros(n, np.int32),
        tries=np.zeros(n, np.int32),
        is_anew=np.zeros(n, np.bool_),
        outcome=np.zeros(n, np.int8),
        asks=np.full(n, way_nb.SET_OUT, np.int8),
        point=np.zeros((n, 3)),
        floor=np.zeros(n),
        ceiling=np.full(n, np.inf),
        from_patch=np.full(n, -1, np.int32),
        from_uv=np.zeros((n, 2)),
        nearest=empty_projection(n),
        other=empty_projection(n),
        followed=empty_projection(n),
        rows=np.arange(n, dtype=np.int32),
        within=np.full(n, np.inf),
    )
    tables = surface.contact_tables if options.balls else None
    if tables is None:
        _ask_surface(surface, ways, options.limits)
    else:
        run_ranges(straight(way_nb.go_all_the_way), n, WAYS, tables, ways, options.limits)
    return ways


def _ask_surface(surface: Surface, ways: Ways, limits: Limits) -> None:
    """Go along all ways together, round by round."""
    go_on = straight(way_nb.go_on)
    left = ways.rows
    while len(left):
        go_on(ways, limits, left)
        asks = ways.asks[left]
        closest = left[asks == way_nb.CLOSEST]
        is_facing = (asks == way_nb.FACING) | (asks == way_nb.FACING_ANYWHERE)
        facing = left[is_facing]
        if len(closest):
            surface.closest(ways.point, closest, ways.nearest)
        if len(facing):
            out = empty_projection(len(facing))
            places = SurfacePlaces(ways.patch[facing], ways.uv[facing])
            limit = FacingLimits(OPPOSITE_COSINE, ways.floor[facing], ways.ceiling[facing])
            surface.closest_facing(ways.point[facing], ways.guard[facing], limit, places, out)
            take(ways.other, facing, out, np.ones(len(facing), np.bool_))
        back = left[(asks != way_nb.CLOSEST) & ~is_facing & (asks != way_nb.DONE)]
        if len(back):
            out = empty_projection(len(back))
            surface.track(ways.point[back], ways.from_patch[back], ways.from_uv[back], out)
            take(ways.followed, back, out, np.ones(len(back), np.bool_))
        left = left[asks != way_nb.DONE]
