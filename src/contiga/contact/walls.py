"""The wall that pushes a point inside of a closed body.

It is the nearest one, as long as that is not opposite: its outward normal makes less than 160° with
the point's guard, which is the normal of the wall that was the nearest one before. Where it is
opposite it does not take over, nor does one that has been nearer all along. The point is then held
by the nearest wall that does not face away from its guard, and the guard stays as it is until the
nearest wall is not opposite to it any more. So the depth is continuous: the distance to all of the
surface, or to walls that stay the same (`docs/theory.md`).

Open bodies have no inside to measure from. On them feet are followed, and a followed foot gives way
to a nearer one of the same sheet that is not opposite and was not nearer before: then it has become
as near on the way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import row_lengths, row_products
from contiga.contact.kernels.settle_nb import ANOTHER, LEAST, PART
from contiga.contact.tracked import BoolArray, Options, Tracked, closest, distances, take
from contiga.masters.protocol import Surface
from contiga.records import (
    FacingLimits,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
    rows_of,
)
from contiga.statuses import Feature, Status

# Parts that ways are gone along in at least, where they are, and that are halved no further to see
# whether the nearest wall turned little by little; looks at places on a way, and its end.
WIDEST, SHORTEST = 2.0**-6, 2.0**-10
LOOKS = 256
END = 1.0 - 1e-9
# Minima that are asked for one after the other, where the nearest has been nearer all along.
TRIES = 8
# Times its way by which a foot's depth may exceed the least that it can have come to, and rounding.
ROUND = 2.0 + 1e-6


Known = tuple[FloatArray, FloatArray, BoolArray]
"""Of points where they started: guards (n, 3), zero where there is none; how deep they were, −inf
where they came in; whose nearest walls were opposite to those that held them."""


class Held(NamedTuple):
    """Points and the walls that push them, one row each."""

    feet: Projection
    guard: FloatArray
    """(n, 3)"""
    opposed: BoolArray
    """Whose nearest wall is opposite, so that another one pushes."""
    anew: BoolArray
    """Whose nearest wall is opposite and pushes all the same, as there is no other."""


def hold(
    surface: Surface,
    way: tuple[FloatArray, FloatArray],
    known: Known,
    last: Projection,
    nearest: Projection,
    band: float,
) -> Held:
    """The feet of points that went `way` = (from, to), inside of the body all along.

    `last` are the feet that were followed from where they started, and `nearest` the closest points
    at the end. Distances are rounded by up to `band`.
    """
    guard, depth, opposed = known
    length = row_lengths(way[1] - way[0])
    feet = Projection._make(column.copy() for column in nearest)
    none = np.zeros(len(guard), dtype=bool)
    held = Held(feet, guard.copy(), none, none.copy())
    along = row_products(nearest.normal, guard)
    other = opposed | (along < LEAST) | (-nearest.gap < depth - length - 2.0 * band)
    # A way on which a point comes to another wall may have led past walls between.
    long = (along < ANOTHER) & (length > -PART * nearest.gap) & guard.any(axis=1)
    rows = np.flatnonzero(other | long)
    if len(rows) == 0:
        return held
    starts = np.where(last.status[rows] == Status.OK, last.patch[rows], -1), last.uv[rows]
    walk = _Walk(way[0][rows], way[1][rows], guard[rows], depth[rows], opposed[rows], *starts)
    facing, anew = _go(surface, walk, length[rows], rows_of(nearest, rows), band)
    held.guard[rows] = walk.guard
    held.anew[rows[anew]] = True
    held.opposed[rows] = walk.opposed
    beyond = np.flatnonzero(walk.opposed)
    take(feet, rows[beyond], rows_of(facing, beyond), walk.opposed[beyond])
    return held


class _Walk(NamedTuple):
    """Points on their ways, one row each; all but the ends change as they go."""

    start: FloatArray
    end: FloatArray
    guard: FloatArray
    depth: FloatArray
    """(n,) how deep they are, −inf where they came in."""
    opposed: BoolArray
    """(n,) whose nearest walls are opposite."""
    patch: IntArray
    """(n,) where their feet are, with (n, 2)."""
    uv: FloatArray

    def place(self, rows: IndexArray, share: FloatArray) -> FloatArray:
        """(len(rows), 3) places at shares of some ways."""
        return self.end[rows] - (1.0 - share[:, None]) * (self.end[rows] - self.start[rows])


def _go(
    surface: Surface, walk: _Walk, length: FloatArray, nearest: Projection, band: float
) -> tuple[Projection, BoolArray]:
    """Take points along their ways, of this `length`, to where `nearest` are their closest points.

    Returns feet of walls that do not face away, of the points that are opposed, and which points
    the nearest wall holds though it is opposite, as there is no other.
    """
    n = len(length)
    facing, anew = empty_projection(n), np.zeros(n, dtype=bool)
    longest = np.clip(-PART * nearest.gap / np.maximum(length, 1e-300), WIDEST, 1.0)
    at, part, left = np.zeros(n), longest.copy(), np.arange(n)
    for _ in range(LOOKS):
        if len(left) == 0:
            break
        place = at[left] + part[left]
        place[place > END] = 1.0
        gone = (place - at[left]) * length[left]
        part_B = walk.place(left, at[left]), walk.place(left, place)
        feet, between = rows_of(nearest, left), np.flatnonzero(place < 1.0)
        out = closest(surface, part_B[1], between.astype(np.int32))
        take(feet, between, out, np.ones(len(between), dtype=bool))
        pushes, held, other = _look(surface, walk, (*part_B, gone), left, feet, band)
        # Both distances change by no more than the way: where they differ by more than twice that,
        # the nearest wall has been opposite all along. Else it may have turned little by little.
        sure = walk.opposed[left] | (feet.gap - other.gap > 2.0 * gone) | (part[left] <= SHORTEST)
        again = ~pushes & ~sure & (-feet.gap >= walk.depth[left] - gone - 2.0 * band)
        on = ~again
        took = left[on & ~held]
        _stand(walk, took, rows_of(feet, np.flatnonzero(on & ~held)), opposed=False)
        _stand(walk, left[on & held], rows_of(other, np.flatnonzero(on & held)), opposed=True)
        anew[left[on & ~held & ~pushes]] = True
        at[left[on]] = place[on]
        part[left] = np.where(again, 0.5 * part[left], np.minimum(2.0 * part[left], longest[left]))
        ended = on & held & (place == 1.0)
        take(facing, left[ended], rows_of(other, np.flatnonzero(ended)), ended[ended])
        left = left[at[left] < 1.0]
    walk.opposed[left], anew[left] = False, True
    return facing, anew


def _look(
    surface: Surface,
    walk: _Walk,
    part: tuple[FloatArray, FloatArray, FloatArray],
    rows: IndexArray,
    feet: Projection,
    band: float,
) -> tuple[BoolArray, BoolArray, Projection]:
    """Whether the nearest walls push points of a walk, `rows`, at the end of a `part` = (from, to,
    length); whether other walls hold them, and the feet on those."""
    before, p_B, gone = part
    guard, least = walk.guard[rows], walk.depth[rows] - gone - 2.0 * band
    pushes = row_products(feet.normal, guard) >= LEAST
    pushes &= -feet.gap >= least
    near = np.where(walk.opposed[rows], walk.depth[rows] - 2.0 * band, -np.inf)
    pushes &= _were_off(surface, before, feet, (guard, near))
    other, asked, floor = rows_of(feet, np.arange(len(rows))), np.flatnonzero(~pushes), least.copy()
    for _ in range(TRIES):
        if len(asked) == 0:
            break
        starts = walk.patch[rows[asked]], walk.uv[rows[asked]]
        out = _facing(surface, p_B[asked], (guard[asked], floor[asked]), starts)
        take(other, asked, out, np.ones(len(asked), dtype=bool))
        asked = asked[~_were_off(surface, before[asked], out, (guard[asked], near[asked]))]
        floor[asked] = 2.0 * band - other.gap[asked]
    other.status[asked] = Status.MAX_ITERATIONS
    # Where the wall that held a point has vanished, others are farther than they can have come.
    deepest = np.where(np.isfinite(least), least + ROUND * gone + 4.0 * band, np.inf)
    held = ~pushes & (other.status == Status.OK) & (-other.gap <= deepest)
    return pushes, held, other


def _were_off(
    surface: Surface, before: FloatArray, feet: Projection, known: tuple[FloatArray, FloatArray]
) -> BoolArray:
    """Whether the walls of some feet were no nearer to the points `before` (n, 3) than is `known`:
    (guard (n, 3), depth (n,)).

    A wall that was nearer than the one that holds a point has been nearer all along, even if a part
    of its way is long enough for both to be as near. Where a foot on an edge leads back to an
    opposite wall it was not that which is asked for.
    """
    guard, near = known
    off = np.ones(len(near), dtype=bool)
    asked = np.flatnonzero((near > 0.0) & (feet.status == Status.OK))
    if len(asked):
        back = empty_projection(len(asked))
        surface.track(before[asked], feet.patch[asked], feet.uv[asked], back)
        off[asked] = distances(back, before[asked]) >= near[asked]
        off[asked] |= row_products(back.normal, guard[asked]) < LEAST
    return off


def _stand(walk: _Walk, rows: IndexArray, feet: Projection, opposed: bool) -> None:
    """Put points of a walk on their nearest walls, whose normals are their guards, or on others
    where those are `opposed`."""
    walk.depth[rows], walk.patch[rows], walk.uv[rows] = -feet.gap, feet.patch, feet.uv
    walk.opposed[rows] = opposed
    if not opposed:
        walk.guard[rows] = feet.normal


def _facing(
    surface: Surface,
    p_B: FloatArray,
    known: tuple[FloatArray, FloatArray],
    starts: tuple[IntArray, FloatArray],
) -> Projection:
    """Feet on walls that do not face away and are not too near, `known` as of `hold`; looked for
    about `starts` first."""
    out = empty_projection(len(p_B))
    patch, uv = starts[0].astype(np.int32), np.ascontiguousarray(starts[1])
    points, guards, least = (np.ascontiguousarray(values) for values in (p_B, *known))
    limits, places = FacingLimits(LEAST, least), SurfacePlaces(patch, uv)
    surface.closest_facing(points, guards, limits, places, out)
    return out


def give_way(
    surface: Surface,
    tracked: Tracked,
    way: tuple[FloatArray, FloatArray],
    depth: FloatArray,
    options: Options,
) -> None:
    """Put the feet in place that followed ones give way to.

    Points went `way` = (from, to), and were so deep before, (n,). What becomes as near within the
    step is nearer at its end by no more than they have gone. On the border of a sheet, feet are
    followed alone.
    """
    if not (options.nearest and surface.has_edges):
        return
    feet = tracked.feet
    rows = np.flatnonzero(tracked.keep & ~tracked.at_border & (feet.gap < -options.band))
    rows = rows[~_are_nearest(surface, feet, rows.astype(np.int32), options)]
    if len(rows) == 0:
        return
    start, end = way[0][rows], way[1][rows]
    length = row_lengths(end - start)
    known = feet.normal[rows], depth[rows] - length - options.band
    other = _facing(surface, end, known, (feet.patch[rows], feet.uv[rows]))
    nearer = (other.status == Status.OK) & (other.feature == Feature.FACE)
    nearer &= other.gap > feet.gap[rows] + options.band
    near = np.where(nearer, depth[rows] - options.band, 0.0)
    nearer &= _were_off(surface, start, other, (feet.normal[rows], near))
    nearer[nearer] = surface.are_joined(other.patch[nearer], feet.patch[rows[nearer]])
    take(feet, rows[nearer], rows_of(other, np.flatnonzero(nearer)), nearer[nearer])


def _are_nearest(surface: Surface, feet: Projection, rows: IntArray, options: Options) -> BoolArray:
    """Of which rows the touching balls prove that nothing is nearer."""
    if not options.balls:
        return np.zeros(len(rows), dtype=bool)
    inner = np.zeros(len(rows), np.int8)
    radius = surface.touching_ball(feet.patch, feet.uv, rows, inner)
    return np.asarray(
        (feet.feature[rows] == Feature.FACE) & (options.band - feet.gap[rows] <= radius)
    )
