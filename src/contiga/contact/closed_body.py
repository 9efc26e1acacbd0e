"""The step on a closed body: a point is inside or outside, whatever its foot.

In contact means inside and come in. Neither is left to the crossings that a search has seen: at
the end of every step each point's side is proved, by the cell it lies in (`Surface.sides`), by the
ball that touches the surface at its foot (`Surface.inner_ball`), by the way it can have gone since
its side was last known, or by its closest point. Crossings only tell where a point that lies
inside has come in (`judge`); they are not looked for on ways that are known to meet no surface.
"""

from __future__ import annotations

import numpy as np

from contiga.contact.judge import Asked, asked_of, free_distance, joined, judge, within_depth
from contiga.contact.tracked import (
    BoolArray,
    Detected,
    Options,
    Step,
    Tracked,
    closest,
    continued,
    distances,
    remember,
    take,
    track,
)
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    rows_of,
)
from contiga.statuses import Feature

# A point that went no farther than this share of the body's size has its last foot near by.
SHORT = 2e-3


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
) -> None:
    """Fill `found` for the points that were in contact and the free ones that are near.

    `last` is (patch, uv) of the feet of all points, `rows` (in contact, near).
    """
    touching, near = rows
    asked = joined(
        _look_at_touching(surface, step, last, touching, found, options),
        _look_at_free(surface, step, near, found, options),
    )
    if len(asked.rows):
        judge(surface, step, asked, found, options)


def _look_at_touching(
    surface: Surface,
    step: Step,
    last: tuple[IntArray, FloatArray],
    rows: IntArray,
    found: Detected,
    options: Options,
) -> Asked:
    """Settle the points in contact whose sides and feet tell what becomes of them.

    Returns the others. What is outside needs no foot.
    """
    side, safe_distance = surface.sides(step.now, rows)
    _release(rows, side > 0, safe_distance, found, options)
    rows, safe_distance, side = rows[side <= 0], safe_distance[side <= 0], side[side <= 0]
    path = (step.before[rows], step.now[rows])
    tracked = track(surface, path, (last[0][rows], last[1][rows]), options)
    # What is no deeper than rounding is on the surface.
    kept = tracked.keep & ((found.safe_distance[rows] > 0.0) | (-tracked.feet.gap <= options.band))
    ways = np.flatnonzero(tracked.keep & ~kept & (side < 0))
    kept[ways] = surface.clear_ways(step.before, step.now, rows[ways])
    doubtful = np.flatnonzero(~kept)
    nearest = ask_balls(surface, tracked, doubtful, (side, safe_distance), options)
    kept[doubtful] = nearest & tracked.keep[doubtful]
    found.safe_distance[rows] = np.fmax(
        found.safe_distance[rows], np.where(side < 0, safe_distance - options.band, 0.0)
    )
    status = continued(tracked)
    found.status[rows[kept]] = status[kept]
    take(found.feet, rows, tracked.feet, kept)
    out = side > 0
    _release(rows, out, safe_distance, found, options)
    remember(found, rows[out], rows_of(tracked.feet, np.flatnonzero(out)))
    own = np.flatnonzero(~kept & ~out)
    feet = rows_of(tracked.feet, own)
    within = distances(tracked, step.now[rows])[own]
    return asked_of(
        rows[own], (side[own], safe_distance[own]), within, (tracked.keep[own], status[own], feet)
    )


def _release(
    rows: IntArray, out: BoolArray, safe_distance: FloatArray, found: Detected, options: Options
) -> None:
    """Points that were in contact and are proved to be outside."""
    found.status[rows[out]] = ContactStatus.RELEASED
    found.safe_distance[rows[out]] = safe_distance[out] - options.band


def _look_at_free(
    surface: Surface, step: Step, rows: IntArray, found: Detected, options: Options
) -> Asked:
    """Settle the free points that are known to stay so; returns the others."""
    side, safe_distance = surface.sides(step.now, rows)
    within = np.full(len(rows), np.inf)
    unknown = np.flatnonzero(side == 0)
    told = np.flatnonzero(side)
    found.near[rows[told]] = -1
    patch, uv = _starts(surface, step, rows[unknown], options)
    unknown, patch, uv = unknown[patch >= 0], patch[patch >= 0], uv[patch >= 0]
    points = step.now[rows[unknown]]
    tracked = track(surface, (None, points), (patch, uv), options)
    remember(found, rows[unknown], tracked.feet)
    within[unknown] = distances(tracked, points)
    own = side[unknown], safe_distance[unknown]
    ask_balls(surface, tracked, np.arange(len(unknown)), own, options)
    side[unknown], safe_distance[unknown] = own
    held = _held(surface, step, rows, side, options)
    done = held | (side > 0)
    found.safe_distance[rows[done]] = (side * (safe_distance - options.band))[done]
    return asked_of(rows[~done], (side[~done], safe_distance[~done]), within[~done])


def _starts(
    surface: Surface, step: Step, rows: IntArray, options: Options
) -> tuple[IntArray, FloatArray]:
    """Where the feet of free points are looked for from: at the last foot or near by."""
    patch, uv = surface.nearby(step.now, rows)
    old = (step.near[rows] >= 0) & ((step.way[rows] <= SHORT * options.size) | (patch < 0))
    return np.where(old, step.near[rows], patch), np.where(old[:, None], step.uv[rows], uv)


def _held(
    surface: Surface, step: Step, rows: IntArray, side: ByteArray, options: Options
) -> BoolArray:
    """Which points lie inside since the start and have not come in: their ways cross nothing.

    A search by penetration asks how deep they are.
    """
    held = np.zeros(len(rows), dtype=bool)
    if options.penetration:
        return held
    own = np.flatnonzero((side < 0) & step.ignored[rows] & np.isfinite(step.way[rows]))
    held[own] = surface.clear_ways(step.before, step.now, rows[own])
    rest = own[~held[own]]
    _, sense = surface.last_crossings(step.before, step.now, rows[rest])
    held[rest] = sense == 0
    return held


def ask_balls(
    surface: Surface,
    tracked: Tracked,
    rows: IndexArray,
    known: tuple[ByteArray, FloatArray],
    options: Options,
) -> BoolArray:
    """Fill in the sides that feet prove, known = (side, reach), of `rows` of `tracked`.

    A ball of radius ρ touches at the foot and holds no surface: a point is on its side up to 2ρ
    from the foot, and no wall is nearer than the ball's nearer end. Returns whether the feet of
    `rows` are proved to be the closest points (up to ρ).
    """
    side, safe_distance = known
    feet = tracked.feet
    sound = tracked.solved & ~tracked.at_border & (feet.feature == Feature.FACE)
    sound &= np.abs(feet.gap) > options.band
    nearest = np.zeros(len(side), dtype=bool)
    if not options.balls:
        return nearest[rows]
    for sign, balls in ((-1, surface.inner_ball), (1, surface.outer_ball)):
        own = rows[sound[rows] & (sign * feet.gap[rows] > 0.0)].astype(np.int32)
        height = np.abs(feet.gap[own])
        radius = balls(feet.patch, feet.uv, own)
        way = np.minimum(height, 2.0 * radius - height)
        told = (way > options.band) & (side[own] != -sign)
        nearest[own] = height + options.band <= radius
        side[own[told]] = sign
        safe_distance[own[told]] = np.fmax(safe_distance[own[told]], way[told])
    return nearest[rows]
