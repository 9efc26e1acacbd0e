"""Search and detailed search of one step: which points touch, and where their feet are.

Free points (type a): a point that cannot have come as far as the surface is left alone (distance
is 1-Lipschitz); the others sweep the segment of their step against it, in the body's frame, and
those that enter start their foot where they entered. Points in contact (type b): the foot is
continued from the last one; the point is released when it is back on the free side (Eq. 4.7 with
the sign put right) and has slid off when the foot passed a border of the body. A closed body can
also be left by another face than the one the foot is on: the path is swept backwards too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.records import ByteArray, ContactStatus, FloatArray, IntArray, Projection, Status
from contiga.search.projection import empty_projection, rows_of
from contiga.search.surface import Surface

BoolArray = NDArray[np.bool_]


# Feet closer than this, relative to the body's size, are one.
SAME_FOOT = 1e-9
# A point this many steps deep is looked at anew only when it has gone as far as the surface is off:
# finding that out costs some ten sweeps.
DEEP_STEPS = 16.0


class Options(NamedTuple):
    """What the search of a contact is to do."""

    penetration: bool
    """Search by penetration: points count as in contact where they lie inside."""
    hold: bool
    """Keep points that slide over a border on its closest point."""
    depth: float
    """Deepest penetration a search by penetration takes for one, length."""
    closed: bool
    """Whether the body is closed: a point is inside or outside, whatever its foot."""
    size: float
    """Of the body, length."""


class Last(NamedTuple):
    """What the search needs to know of the last step."""

    points_B: FloatArray
    patch: IntArray
    uv: FloatArray
    reach: FloatArray


class Detected(NamedTuple):
    """Outcome of the search for n points; feet in body axes, blank without contact."""

    status: ByteArray
    feet: Projection
    reach: FloatArray


def _blank(n: int) -> Projection:
    feet = empty_projection(n)
    feet.patch[:] = -1
    feet.uv[:] = 0.0
    feet.point[:] = 0.0
    feet.normal[:] = 0.0
    feet.gap[:] = 0.0
    feet.feature[:] = -1
    feet.status[:] = 0
    feet.certified[:] = 0
    return feet


def first_look(surface: Surface, p_B: FloatArray, active: np.ndarray, options: Options) -> Detected:
    """The start: nothing is in contact, or, by penetration, what already lies inside."""
    n = len(p_B)
    finite = np.isfinite(p_B).all(axis=1)
    status = np.where(finite, ContactStatus.FREE, ContactStatus.NOT_FINITE).astype(np.int8)
    feet = _blank(n)
    reach = np.full(n, np.inf)
    rows = np.flatnonzero(finite & active).astype(np.int32)
    surface.reach(p_B, rows, reach)
    if options.penetration:
        _look_inside(surface, p_B, rows, (status, feet, reach), options)
    return Detected(status, feet, reach)


def look(
    surface: Surface, now: FloatArray, last: Last, active: np.ndarray, options: Options
) -> Detected:
    """One step: from the points of the last step to those of this one, body axes."""
    before = last.points_B
    n = len(now)
    finite = np.isfinite(now).all(axis=1)
    status = np.where(finite, ContactStatus.FREE, ContactStatus.NOT_FINITE).astype(np.int8)
    feet = _blank(n)
    touching = finite & (last.patch >= 0)
    with np.errstate(invalid="ignore", over="ignore"):
        way = np.sqrt(np.square(now - before).sum(axis=1))
    reach = last.reach - way
    rows = np.flatnonzero(touching).astype(np.int32)
    within = _continue(surface, (now, way, reach), last, rows, (status, feet, options))
    free = finite & active & ~touching
    # A point that was not finite has no path to sweep: it is looked at afresh.
    came_back = free & ~np.isfinite(before).all(axis=1)
    reach[came_back] = 0.0
    reach[~free] = 0.0
    reach[~active] = np.inf
    reach[rows] = within
    near = np.flatnonzero(free & (reach <= 0.0)).astype(np.int32)
    if options.penetration:
        _look_inside(surface, now, near, (status, feet, reach), options)
    else:
        _sweep(surface, (before, now), near, (status, feet, options))
        rest = near[feet.patch[near] < 0]
        surface.reach(now, rest, reach)
    return Detected(status, feet, reach)


class _Tracked(NamedTuple):
    """Feet continued from where they were, and what is to become of them."""

    feet: Projection
    solved: BoolArray
    at_border: BoolArray
    keep: BoolArray
    """Inside, and on the surface or (where the options hold it) on its border."""


def _track(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    patch: IntArray,
    uv: FloatArray,
    options: Options,
) -> _Tracked:
    before, p_B = path
    out = empty_projection(len(p_B))
    surface.track(p_B, patch, np.ascontiguousarray(uv), out, before)
    failed = np.flatnonzero(out.status == Status.MAX_ITERATIONS).astype(np.int32)
    surface.closest(p_B, failed, out)
    at_border = (out.status == Status.BORDER) | (out.status == Status.TRIMMED)
    # A minimum that vanished on the way has the closest point for a foot.
    solved = (out.status == Status.OK) | (out.status == Status.BRANCH_EVENT) | at_border
    keep = solved & (out.gap <= 0.0) & (options.hold | ~at_border)
    return _Tracked(out, solved, at_border, keep)


def _continue(
    surface: Surface,
    moved: tuple[FloatArray, FloatArray, FloatArray],
    last: Last,
    rows: IntArray,
    result: tuple[ByteArray, Projection, Options],
) -> FloatArray:
    """Old contacts (type b): continue the feet, release what came back, went through or slid off.

    `moved` is where all points are, how far they have gone and what is left of their reach.
    Returned is the reach of `rows`.
    """
    now, way, reach = moved
    status, feet, options = result
    within = np.zeros(len(rows))
    if len(rows) == 0:
        return within
    own = last.points_B[rows], now[rows]
    found = _track(surface, own, last.patch[rows], last.uv[rows], options)
    keep = found.keep
    if options.closed:
        within = np.where(keep, reach[rows], 0.0)
        due = np.flatnonzero(keep & (within <= 0.0)).astype(np.int32)
        path = last.points_B, now
        left, within[due] = _left(surface, path, rows[due], rows_of(found.feet, due), way, options)
        keep[due[left]] = False
    held = np.where(found.at_border, ContactStatus.HELD, ContactStatus.OLD)
    slid_off = found.at_border & (not options.hold)
    gone = np.where(slid_off, ContactStatus.SLID_OFF, ContactStatus.RELEASED)
    new = np.where(keep, held, gone)
    status[rows] = np.where(found.solved, new, ContactStatus.LOST)
    _take(feet, rows, found.feet, keep)
    return within


def _left(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    rows: IntArray,
    feet: Projection,
    way: FloatArray,
    options: Options,
) -> tuple[BoolArray, FloatArray]:
    """Points inside a closed body by their tracked feet that have left it by another face.

    The step swept backwards enters the body where the point has gone out of it, and the closest
    point then says on which side it is. Also returned is how far the others can go before that
    has to be asked again: zero unless they are many steps deep.
    """
    before, now = path
    left, within = np.zeros(len(rows), dtype=bool), np.zeros(len(rows))
    back = surface.entries(now, before, rows)
    asked = np.flatnonzero((back.patch >= 0) | (-feet.gap > DEEP_STEPS * way[rows]))
    if len(asked) == 0:
        return left, within
    out = empty_projection(len(asked))
    points = np.ascontiguousarray(now[rows[asked]])
    surface.closest(points, np.arange(len(asked), dtype=np.int32), out)
    apart = np.sqrt(np.square(out.point - feet.point[asked]).sum(axis=1))
    solved = out.status == Status.OK
    left[asked] = solved & (out.gap > 0.0) & (apart > SAME_FOOT * options.size)
    within[asked] = np.where(solved, np.maximum(-out.gap, 0.0), 0.0)
    return left, within


def _sweep(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    rows: IntArray,
    result: tuple[ByteArray, Projection, Options],
) -> None:
    """New contacts (type a): points whose step enters the body, feet started at the entry."""
    status, feet, options = result
    before, now = path
    hits = surface.entries(before, now, rows)
    entered = np.flatnonzero(hits.patch >= 0)
    if len(entered) == 0:
        return
    rows = rows[entered]
    inner = hits.point[entered], now[rows]
    found = _track(surface, inner, hits.patch[entered], hits.uv[entered], options)
    keep = found.keep
    if options.closed:
        due = np.flatnonzero(keep).astype(np.int32)
        ahead = np.full(len(now), np.inf)  # nothing is known of a way to come
        left, _ = _left(surface, path, rows[due], rows_of(found.feet, due), ahead, options)
        keep[due[left]] = False
    new = np.where(found.at_border, ContactStatus.HELD, ContactStatus.NEW)
    status[rows[keep]] = new[keep]
    status[rows[~found.solved]] = ContactStatus.LOST
    _take(feet, rows, found.feet, keep)


def _look_inside(
    surface: Surface,
    p_B: FloatArray,
    rows: IntArray,
    result: tuple[ByteArray, Projection, FloatArray],
    options: Options,
) -> None:
    """Search by penetration: points that lie inside, feet at the closest points."""
    status, feet, reach = result
    out = empty_projection(len(rows))
    inner = np.ascontiguousarray(p_B[rows])
    surface.closest(inner, np.arange(len(rows), dtype=np.int32), out)
    # Behind an open surface, deeper than contact reaches or beside its border, a point is as far
    # from contact as from that depth. A foot that was not found (NaN) is looked for again.
    reach[rows] = np.where(out.gap > 0.0, out.gap, np.fmax(-out.gap - options.depth, 0.0))
    keep = (out.status == Status.OK) & (out.gap <= 0.0) & (out.gap >= -options.depth)
    status[rows[keep]] = ContactStatus.NEW
    _take(feet, rows, out, keep)


def _take(feet: Projection, rows: IntArray, out: Projection, keep: BoolArray) -> None:
    """Write the rows of `out` that are kept into `rows` of `feet`."""
    rows = rows[keep]
    feet.patch[rows] = out.patch[keep]
    feet.uv[rows] = out.uv[keep]
    feet.point[rows] = out.point[keep]
    feet.normal[rows] = out.normal[keep]
    feet.gap[rows] = out.gap[keep]
    feet.feature[rows] = out.feature[keep]
    feet.status[rows] = out.status[keep]
    feet.certified[rows] = out.certified[keep]
