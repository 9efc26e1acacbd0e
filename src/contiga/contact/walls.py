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

from contiga.contact.kernels.settle_nb import LEAST
from contiga.contact.tracked import BoolArray, Options, Tracked, closest, take
from contiga.masters.protocol import Surface
from contiga.records import FloatArray, IndexArray, IntArray, Projection, empty_projection, rows_of
from contiga.statuses import Feature, Status

# Of its way, below which it is not looked at whether the nearest wall turned little by little.
SHORTEST = 2.0**-10
# Looks at places on a way, and the part of it that is looked at first.
LOOKS = 48
FIRST = 1.0 / 16.0
# Cosine of the normals of a guard and of a wall that is another one.
ANOTHER = 0.7
# Times its way by which a foot's depth may exceed the least that it can have come to, and rounding.
ROUND = 2.0 + 1e-6


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
    known: tuple[FloatArray, FloatArray],
    last: Projection,
    nearest: Projection,
) -> Held:
    """The feet of points that went `way` = (from, to), inside of the body all along.

    `known` is (guard (n, 3) where they started, zero where there is none; (n,) how near feet may be
    at the end that were not nearer at the start), `last` the feet that were followed from there,
    and `nearest` the closest points at the end.
    """
    guard, least = known
    n, length = len(guard), np.sqrt(np.square(way[1] - way[0]).sum(axis=1))
    feet = Projection._make(column.copy() for column in nearest)
    held = Held(feet, guard.copy(), np.zeros(n, dtype=bool), np.zeros(n, dtype=bool))
    along = (nearest.normal * guard).sum(axis=1)
    asked = (along < LEAST) | (-nearest.gap < least)
    # A way longer than the point is deep may have led past walls between.
    long = guard.any(axis=1) & (along < ANOTHER) & (length > -nearest.gap)
    own = np.flatnonzero(asked | long)
    if len(own) == 0:
        return held
    known, ends = (guard[own], least[own]), (way[0][own], way[1][own])
    starts = np.where(last.status[own] == Status.OK, last.patch[own], -1), last.uv[own]
    facing = rows_of(nearest, own)
    _face(surface, facing, ends[1], known, starts, np.flatnonzero(asked[own]))
    # Both distances change by no more than the way: where they differ by more than twice that, the
    # nearest wall has been opposite all along.
    sure = asked[own] & (nearest.gap[own] - facing.gap > 2.0 * length[own])
    doubt = np.flatnonzero(~sure & ((along[own] < LEAST) | long[own]))
    turned, reached = _turned(surface, (ends[0][doubt], ends[1][doubt]), guard[own[doubt]])
    held.guard[own[doubt]] = turned
    changed = (turned != guard[own[doubt]]).any(axis=1) | ~asked[own[doubt]]
    known = held.guard[own], least[own]
    _face(surface, facing, ends[1], known, starts, doubt[changed & ~reached])
    opposed = np.ones(len(own), dtype=bool)
    opposed[doubt[reached]] = False
    # Where the wall that held a point has vanished, others are farther than they can have come.
    deepest = np.where(np.isfinite(least), least + ROUND * length, np.inf)[own]
    none = opposed & ((facing.status != Status.OK) | (-facing.gap > deepest))
    held.anew[own[none]] = True
    opposed &= ~none
    held.opposed[own[opposed]] = True
    take(feet, own[opposed], rows_of(facing, np.flatnonzero(opposed)), opposed[opposed])
    return held


def _face(
    surface: Surface,
    facing: Projection,
    p_B: FloatArray,
    known: tuple[FloatArray, FloatArray],
    starts: tuple[IntArray, FloatArray],
    rows: IndexArray,
) -> None:
    """Write feet on walls that do not face away into some rows of `facing`; else as `_facing`."""
    some = (known[0][rows], known[1][rows]), (starts[0][rows], starts[1][rows])
    take(facing, rows, _facing(surface, p_B[rows], *some), np.ones(len(rows), dtype=bool))


def _is_opposite(normal: FloatArray, guard: FloatArray) -> BoolArray:
    return np.asarray((normal * guard).sum(axis=1) < LEAST)


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
    surface.closest_facing(points, guards, (LEAST, least), (patch, uv), out)
    return out


def _turned(
    surface: Surface, way: tuple[FloatArray, FloatArray], guard: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Guards after ways on which the nearest wall may have turned little by little; and whether it
    is not opposite at the end.

    A long step may go from one wall to the opposite one by others between. Parts of the way are
    halved until the nearest wall at the end of a part is not opposite to that at its start.
    """
    guard, done = guard.copy(), np.zeros(len(guard), dtype=bool)
    at, part = np.zeros(len(guard)), np.full(len(guard), FIRST)
    left: IndexArray = np.arange(len(guard))
    for _ in range(LOOKS):
        if len(left) == 0:
            break
        place = np.minimum(at[left] + part[left], 1.0)
        p_B = way[0][left] + place[:, None] * (way[1][left] - way[0][left])
        feet = closest(surface, p_B, np.arange(len(left), dtype=np.int32))
        ok = (feet.status == Status.OK) & ~_is_opposite(feet.normal, guard[left])
        guard[left[ok]] = feet.normal[ok]
        at[left[ok]] = place[ok]
        part[left] = np.where(ok, np.minimum(2.0 * part[left], FIRST), 0.5 * part[left])
        done[left[ok & (place == 1.0)]] = True
        left = left[~done[left] & (part[left] >= SHORTEST)]
    return guard, done


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
    own = np.flatnonzero(tracked.keep & ~tracked.at_border & (feet.gap < -options.band))
    own = own[~_are_nearest(surface, feet, own.astype(np.int32), options)]
    if len(own) == 0:
        return
    start, end = way[0][own], way[1][own]
    length = np.sqrt(np.square(end - start).sum(axis=1))
    known = feet.normal[own], depth[own] - length - options.band
    other = _facing(surface, end, known, (feet.patch[own], feet.uv[own]))
    nearer = (other.status == Status.OK) & (other.feature == Feature.FACE)
    nearer &= other.gap > feet.gap[own] + options.band
    nearer[nearer] = surface.are_joined(other.patch[nearer], feet.patch[own[nearer]])
    take(feet, own[nearer], rows_of(other, np.flatnonzero(nearer)), nearer[nearer])


def _are_nearest(surface: Surface, feet: Projection, rows: IntArray, options: Options) -> BoolArray:
    """Of which rows the touching balls prove that nothing is nearer."""
    if not options.balls:
        return np.zeros(len(rows), dtype=bool)
    inner = np.zeros(len(rows), np.int8)
    radius = surface.touching_ball(feet.patch, feet.uv, rows, inner)
    return np.asarray(
        (feet.feature[rows] == Feature.FACE) & (options.band - feet.gap[rows] <= radius)
    )
