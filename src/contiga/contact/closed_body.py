"""The step on a closed body: a point is inside or outside, whatever its foot.

In contact means inside and come in. Neither is left to the crossings that a search has seen: at
the end of every step each point's side is proved, by the cell it lies in (`Surface.sides`), by the
ball that touches the surface at its foot (`Surface.touching_ball`), by the way it can have gone
since its side was last known, or by its closest point. Crossings only tell where a point that lies
inside has come in (`judge`); they are not looked for on ways that are known to meet no surface.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.contact import usual
from contiga.contact.asked import Asked
from contiga.contact.judge import asked_of, free_distance, joined, judge, within_depth
from contiga.contact.kernels import settle_nb
from contiga.contact.loads import UNGUARDED, Guards
from contiga.contact.tracked import (
    BoolArray,
    Detected,
    Options,
    Step,
    closest,
    continued,
    distances,
    follow,
    remember,
    take,
)
from contiga.jit import straight
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    rows_of,
)
from contiga.search.track.track_records import Starts


class SideEvidence(NamedTuple):
    """What is known of points in contact that are not outside, one row each."""

    rows: IntArray
    known: tuple[ByteArray, FloatArray]
    """(side, reach)."""
    now: FloatArray
    feet: Projection
    mark: ByteArray
    own: IntArray
    """Which of them are not settled."""


def detect_at_start(
    surface: Surface, p_B: FloatArray, rows: IntArray, found: Detected, options: Options
) -> None:
    """The side of every point at the start.

    By intersection, points that lie inside are not in contact until they have been outside.
    """
    side, safe_distance = surface.sides(p_B, rows)
    found.safe_distance[rows] = side * (safe_distance - options.band)
    if options.penetration:
        _take_inside(surface, p_B, rows[side <= 0], found, options)
        return
    rows = rows[side == 0]
    out = closest(surface, p_B, rows)
    found.safe_distance[rows] = free_distance(out, options)
    remember(found, rows, out)


def _take_inside(
    surface: Surface, p_B: FloatArray, rows: IntArray, found: Detected, options: Options
) -> None:
    """A start by penetration: points that lie inside, and no deeper than that reaches."""
    out = closest(surface, p_B, rows)
    found.safe_distance[rows] = free_distance(out, options)
    remember(found, rows, out)
    keep = within_depth(out, options)
    found.status[rows[keep]] = ContactStatus.NEW
    found.safe_distance[rows[keep]] = -out.gap[keep]
    take(found.feet, rows, out, keep)


def detect(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: tuple[IntArray, IntArray],
    found: Detected,
    options: Options,
) -> Guards:
    """Fill `found` for the points that were in contact and the free ones that are near; returns
    those whose nearest wall is opposite to the one that pushes them.

    `last` is (patch, uv) of the feet of all points, `rows` (in contact, near).
    """
    touching, near = usual.left(surface, step, last, rows, found, options)
    held = None
    if len(touching):
        told = _look_at_touching(surface, step, last, touching, found, options)
        held = _left_of(told, step)
    free = _look_at_free(surface, step, near, found, options)
    asked = joined(held, free) if held and free else held or free
    return UNGUARDED if asked is None else judge(surface, step, asked, found, options)


def _look_at_touching(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: IntArray,
    found: Detected,
    options: Options,
) -> SideEvidence:
    """Settle the points in contact whose sides and feet tell what becomes of them.

    What is outside needs no foot.
    """
    known, band = surface.sides(step.now, rows), options.band
    work = _of_touching(len(rows))
    left = straight(settle_nb.stay)(rows, known, step, Starts(*last), found, band, work)
    rows, side, reach, patch, uv, before, now = (values[:left] for values in work)
    (ways, index), (mark, which) = np.empty((2, left), np.int32), np.empty((2, left), np.int8)
    asked = index, which
    if options.nearest:
        feet = follow(surface, (None, now), (patch, uv))
        face = straight(settle_nb.face)
        m = face(rows, feet, step.holds, step.way, band, mark, asked)
    else:
        feet = follow(surface, (before, now), (patch, uv))
        limits = options.hold, band
        n, m = settle_nb.look(rows, feet, side, found.safe_distance, limits, mark, ways, asked)
        if n:
            clear = surface.clear_ways(step.before, step.now, rows[ways[:n]])
            mark[ways[:n][clear]] |= settle_nb.KEPT
    balls = _balls(surface, feet, (index[:m], which[:m]), options)
    known, settle = (side, reach), straight(settle_nb.settle)
    n = settle(rows, feet, known, mark, balls, band, found, ways)
    return SideEvidence(rows, known, now, feet, mark, ways[:n])


def _left_of(told: SideEvidence, step: Step) -> Asked | None:
    """Those points in contact that are not settled, if there are any."""
    rows, known, now, feet, mark, own = told
    if len(own) == 0:
        return None
    feet = rows_of(feet, own)
    kept = (mark[own] & settle_nb.KEEP) > 0
    within = distances(feet, now[own])
    side, reach = known
    tracked = kept, continued(feet), step.holds.at(rows[own]), feet
    return asked_of(rows[own], (side[own], reach[own]), within, tracked)


def _of_touching(n: int) -> tuple[Any, ...]:
    """What is listed of points in contact: rows, sides, reaches, feet, before and now."""
    (rows, patch), (before, now) = np.empty((2, n), np.int32), np.empty((2, n, 3))
    return rows, np.empty(n, np.int8), np.empty(n), patch, np.empty((n, 2)), before, now


def _listed(n: int) -> tuple[IntArray, ByteArray]:
    """Space for a list of feet that balls may tell of, and the sides they touch on."""
    return np.empty(n, np.int32), np.empty(n, np.int8)


def _balls(
    surface: Surface,
    feet: Projection,
    asked: tuple[IntArray, ByteArray],
    options: Options,
) -> tuple[IntArray, FloatArray]:
    """The feet that are asked for, and the radii of the balls that touch there."""
    index, sides = asked
    if len(index) == 0 or not options.balls:
        return index[:0], np.zeros(0)
    return index, surface.touching_ball(feet.patch, feet.uv, index, sides)


def _look_at_free(
    surface: Surface, step: Step, rows: IntArray, found: Detected, options: Options
) -> Asked | None:
    """Settle the free points that are known to stay so; returns the others, if there are any."""
    if len(rows) == 0:
        return None
    side, reach, within, own = _settle_free(surface, step, rows, found, options)
    if len(own) == 0:
        return None
    return asked_of(rows[own], (side[own], reach[own]), within[own])


Sides = tuple[ByteArray, FloatArray, FloatArray, IntArray]
"""(side, reach, within) of free points, and which of them are not settled."""


def _settle_free(
    surface: Surface, step: Step, rows: IntArray, found: Detected, options: Options
) -> Sides:
    """Settle the free points that stay so."""
    side, reach, near, near_uv = surface.places(step.now, rows)
    known, within = (side, reach), np.full(len(rows), np.inf)
    n = len(rows)
    index, patch = np.empty(n, np.int32), np.empty(n, np.int32)
    uv, now = np.empty((n, 2)), np.empty((n, 3))
    far, work = options.far, (index, patch, uv, now)
    starts = straight(settle_nb.starts)
    n = starts(rows, side, Starts(near, near_uv), step, found.last_patch, far, work)
    if n:
        index, patch, uv, now = index[:n], patch[:n], uv[:n], now[:n]
        feet = follow(surface, (None, now), (patch, uv))
        remember(found, rows[index], feet)
        tell(surface, (index, feet, now), known, within, options)
    held = _held(surface, step, rows, side, options)
    own = np.empty(len(rows), np.int32)
    n = straight(settle_nb.leave)(rows, known, held, options.band, found.safe_distance, own)
    return side, reach, within, own[:n]


def tell(
    surface: Surface,
    followed: tuple[IndexArray, Projection, FloatArray],
    known: tuple[ByteArray, FloatArray],
    within: FloatArray,
    options: Options,
) -> None:
    """Fill in what feet tell: the sides that balls prove, and distances to the surface.

    `followed` is (rows, feet, points), `known` (side, reach) and `within` have the rows.
    """
    index, feet, points = followed
    asked = _listed(len(index))
    m = straight(settle_nb.askable)(feet, len(index), options.band, asked)
    balls = _balls(surface, feet, (asked[0][:m], asked[1][:m]), options)
    straight(settle_nb.tell)(index, feet, points, balls, options.band, known, within)


def _held(
    surface: Surface, step: Step, rows: IntArray, side: ByteArray, options: Options
) -> BoolArray:
    """Which points lie inside since the start and have not come in: their ways cross nothing.

    A search by penetration asks how deep they are.
    """
    held = np.zeros(len(rows), dtype=bool)
    inside = side < 0
    if options.penetration or not inside.any():
        return held
    own = np.flatnonzero(inside & step.ignored[rows] & np.isfinite(step.way[rows]))
    if len(own) == 0:
        return held
    held[own] = surface.clear_ways(step.before, step.now, rows[own])
    rest = own[~held[own]]
    _, sense = surface.last_crossings(step.before, step.now, rows[rest])
    held[rest] = sense == 0
    return held
