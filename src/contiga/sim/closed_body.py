"""The step on a closed body: a point is inside or outside, whatever its foot.

In contact means inside and come in. Neither is left to the crossings that a search has seen: at
the end of every step each point's side is proved, by the ball that touches the surface at its foot
(`Surface.inner_ball`), by the way it can have gone since its side was last known, or by its
closest point. Crossings only tell where a point that lies inside has come in; one that lies inside
without a crossing is taken into contact all the same, and marked FOUND.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.records import (
    ByteArray,
    ContactStatus,
    Feature,
    FloatArray,
    IntArray,
    Projection,
    Status,
)
from contiga.search.projection import rows_of
from contiga.search.surface import Surface
from contiga.sim.tracked import (
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

# Feet closer than this, relative to the body's size, are one.
SAME_FOOT = 1e-9
# How far outside a body's box the ways in from there start, relative to its size.
START = 1e-3


class _Asked(NamedTuple):
    """Points whose side the closest point decides, one row an entry of `rows`."""

    rows: IntArray
    was: BoolArray
    """In contact before."""
    kept: BoolArray
    """In contact before, with a foot that would do."""
    status: ByteArray
    """What the foot would make of a point that is kept."""
    feet: Projection
    """The feet that would do; the closest points of the others."""
    truth: Projection
    """The closest points."""


def first_look(
    surface: Surface, p_B: FloatArray, rows: IntArray, found: Detected, options: Options
) -> None:
    """The side of every point at the start.

    By intersection, points that lie inside are not in contact until they have been outside.
    """
    surface.reach(p_B, rows, found.reach)
    side = np.zeros(len(rows), np.int8)
    clear = found.reach[rows] > options.band
    side[clear] = _side_by_ray(surface, p_B, rows[clear], options)
    found.reach[rows] *= side
    rows = rows[side <= 0 if options.penetration else side == 0]
    out = closest(surface, p_B, rows)
    found.reach[rows] = _free_reach(out, options)
    remember(found, rows, out)
    if options.penetration:
        keep = _within_depth(out, options)
        found.status[rows[keep]] = ContactStatus.NEW
        found.reach[rows[keep]] = -out.gap[keep]
        take(found.feet, rows, out, keep)


def _side_by_ray(surface: Surface, p_B: FloatArray, rows: IntArray, options: Options) -> ByteArray:
    """1 for the points p_B[rows] that lie outside, −1 inside, 0 not known; none near the surface.

    Far away all is one side. A point is on it too unless the shortest axis-parallel way in from
    there crosses the surface; then the last crossing tells.
    """
    low, high = options.bounds
    far = closest(surface, (2.0 * high - low)[None, :], np.zeros(1, np.int32)).gap[0] > 0.0
    points = p_B[rows]
    ways = np.concatenate((points - low, high - points), axis=1)
    side = np.full(len(rows), 1 if far else -1, np.int8)
    crossed = np.flatnonzero(ways.min(axis=1) > 0.0)
    ways, start = ways[crossed], points[crossed].copy()
    short = ways.argmin(axis=1)
    step = ways.min(axis=1) + START * options.size
    start[np.arange(len(crossed)), short % 3] += np.where(short < 3, -step, step)
    own = np.arange(len(crossed), dtype=np.int32)
    hits, sense = surface.last_crossings(start, points[crossed], own)
    side[crossed] = np.where(sense == 0, side[crossed], -sense)
    side[crossed[hits.status == Status.BUDGET]] = 0
    return side


def look(
    surface: Surface,
    step: Step,
    rows: tuple[IntArray, IntArray],
    tracked: Tracked,
    found: Detected,
    options: Options,
) -> None:
    """Fill `found` for the points that were in contact and the free ones that are near.

    `rows` is (in contact, near), `tracked` the feet of the first.
    """
    touching, near = rows
    within = np.full(len(step.now), np.inf)
    near = _still_free(surface, step, (near, within), found, options)
    inside = _proved_inside(surface, tracked, options)
    inside |= tracked.keep & (found.reach[touching] > 0.0)
    outside, reach = _proved_outside(surface, tracked, options)
    status = continued(tracked)
    found.status[touching[inside]] = status[inside]
    take(found.feet, touching, tracked.feet, inside)
    found.status[touching[outside]] = ContactStatus.RELEASED
    found.reach[touching[outside]] = reach
    remember(found, touching[outside], rows_of(tracked.feet, np.flatnonzero(outside)))
    doubtful = np.flatnonzero(~inside & ~outside)
    asked = np.concatenate((touching[doubtful], near))
    if len(asked) == 0:
        return
    within[touching] = distances(tracked, step.now[touching])
    truth = closest(surface, step.now, asked, within[asked])
    feet = rows_of(truth, np.arange(len(asked), dtype=np.int32))
    kept = np.zeros(len(asked), dtype=bool)
    kept[: len(doubtful)] = tracked.keep[doubtful]
    take(feet, np.arange(len(doubtful)), rows_of(tracked.feet, doubtful), tracked.keep[doubtful])
    old = np.zeros(len(asked), np.int8)
    old[: len(doubtful)] = status[doubtful]
    was = np.arange(len(asked)) < len(doubtful)
    _judge(surface, step, _Asked(asked, was, kept, old, feet, truth), found, options)


def _still_free(
    surface: Surface,
    step: Step,
    asked: tuple[IntArray, FloatArray],
    found: Detected,
    options: Options,
) -> IntArray:
    """Settle the free points whose feet prove that they stay so; returns the others.

    `asked` is (the points, distances to feet of all points): those that are seen are filled in.
    """
    near, within = asked
    known = step.near[near] >= 0
    rows = near[known]
    tracked = track(surface, (None, step.now[rows]), (step.near[rows], step.uv[rows]), options)
    outside, reach = _proved_outside(surface, tracked, options)
    found.reach[rows[outside]] = reach
    remember(found, rows[outside], rows_of(tracked.feet, np.flatnonzero(outside)))
    held = _still_held(surface, step, rows, tracked, found, options)
    within[rows] = distances(tracked, step.now[rows])
    return np.concatenate((near[~known], rows[~outside & ~held]))


def _still_held(
    surface: Surface,
    step: Step,
    rows: IntArray,
    tracked: Tracked,
    found: Detected,
    options: Options,
) -> BoolArray:
    """Settle those of the points `rows` that lie inside since the start; returns which.

    Their feet prove that they are inside, and what crosses nothing on its way has not come in. A
    search by penetration asks how deep they are, which a foot does not tell so far down.
    """
    held = np.zeros(len(rows), dtype=bool)
    if options.penetration:
        return held
    feet = tracked.feet
    sound = tracked.solved & ~tracked.at_border & (feet.feature == Feature.FACE)
    sound &= step.ignored[rows] & np.isfinite(step.way[rows]) & (-feet.gap > options.band)
    own = np.flatnonzero(sound).astype(np.int32)
    radius = surface.inner_ball(feet.patch, feet.uv, own)
    reach = np.minimum(-feet.gap[own], 2.0 * radius + feet.gap[own]) - options.band
    own, reach = own[reach > 0.0], reach[reach > 0.0]
    _, sense = surface.last_crossings(step.before, step.now, rows[own])
    own, reach = own[sense == 0], reach[sense == 0]
    held[own] = True
    found.reach[rows[own]] = -reach
    remember(found, rows[own], rows_of(feet, own))
    return held


def _judge(surface: Surface, step: Step, asked: _Asked, found: Detected, options: Options) -> None:
    """What becomes of points whose side the closest point tells."""
    rows, was, kept, old_status, feet, truth = asked
    solved = truth.status == Status.OK
    inside = solved & (truth.gap <= 0.0)
    deep = inside & (truth.gap < -options.band)
    apart = np.sqrt(np.square(feet.point - truth.point).sum(axis=1))
    same = kept & (apart <= SAME_FOOT * options.size)
    entered, new = _come_in(surface, step, asked, inside & ~same, options)
    old = kept & ~new & (inside | ~solved)
    # A point that has lain inside since the start, or has no past, need not have come in.
    free = ~was & (step.ignored[rows] | ~np.isfinite(step.way[rows]))
    anew = deep & ~new & ~old & (was | entered)
    missed = deep & ~new & ~old & ~anew & ~free & (not options.penetration)
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[~solved & ~kept] = ContactStatus.LOST
    status[old] = old_status[old]
    status[new] = ContactStatus.NEW
    status[anew] = ContactStatus.REACQUIRED
    status[missed] = ContactStatus.FOUND
    found.status[rows] = status
    touching = old | new | anew | missed
    take(found.feet, rows, feet, touching)
    remember(found, rows[~touching], rows_of(truth, np.flatnonzero(~touching)))
    found.reach[rows] = np.where(
        touching,
        np.where(inside, np.maximum(-truth.gap - options.band, 0.0), 0.0),
        _free_reach(truth, options),
    )


def _come_in(
    surface: Surface, step: Step, asked: _Asked, inside: BoolArray, options: Options
) -> tuple[BoolArray, BoolArray]:
    """Which of the points inside have come in within the step, and with a foot that does.

    What counts is the last crossing: a point may leave by one wall and come in by another. It is
    not asked of points whose feet are the closest points. The feet of those that come in are
    written into `asked.feet`.
    """
    rows, was, _, _, feet, truth = asked
    entered, new = np.zeros(len(rows), dtype=bool), np.zeros(len(rows), dtype=bool)
    if options.penetration:
        entered = ~was & _within_depth(truth, options)
        new = entered.copy()
    which = np.flatnonzero(inside & np.isfinite(step.way[rows]) & (was | (not options.penetration)))
    hits, sense = surface.last_crossings(step.before, step.now, rows[which])
    back = np.flatnonzero(sense > 0)
    which = which[back]
    entered[which] = True
    if options.penetration:
        take(feet, which, rows_of(truth, which), np.ones(len(which), dtype=bool))
        new[which] = True
        return entered, new
    tracked = track(
        surface,
        (hits.point[back], step.now[rows[which]]),
        (hits.patch[back], hits.uv[back]),
        options,
    )
    new[which] = tracked.keep
    take(feet, which, tracked.feet, tracked.keep)
    return entered, new


def _proved_inside(surface: Surface, tracked: Tracked, options: Options) -> BoolArray:
    """Points that are inside by their feet alone: their feet are the closest points.

    A ball of radius ρ touches there from within and holds no surface: a point at a depth of no
    more than ρ below the foot has none nearer. Up to 2ρ it would be inside still, but other walls
    could be nearer, and what came in by one of them would be missed. What is no deeper than
    rounding is on the surface.
    """
    feet = tracked.feet
    depth = -feet.gap
    proved: BoolArray = tracked.keep & (depth <= options.band)
    rows = np.flatnonzero(tracked.keep & ~proved & (feet.feature == Feature.FACE)).astype(np.int32)
    radius = surface.inner_ball(feet.patch, feet.uv, rows)
    proved[rows] = depth[rows] + options.band <= radius
    return proved


def _proved_outside(
    surface: Surface, tracked: Tracked, options: Options
) -> tuple[BoolArray, FloatArray]:
    """Points that are outside by their feet alone, and how far each of them can go at least."""
    feet = tracked.feet
    outside = tracked.solved & ~tracked.at_border & (feet.feature == Feature.FACE)
    rows = np.flatnonzero(outside & (feet.gap > options.band)).astype(np.int32)
    radius = surface.outer_ball(feet.patch, feet.uv, rows)
    # A ball that holds no surface is left by its nearer end.
    reach = np.minimum(feet.gap[rows], 2.0 * radius - feet.gap[rows]) - options.band
    outside[:] = False
    outside[rows] = reach > 0.0
    return outside, reach[reach > 0.0]


def _within_depth(out: Projection, options: Options) -> BoolArray:
    """Points that a search by penetration takes."""
    inside: BoolArray = (out.status == Status.OK) & (out.gap <= 0.0) & (out.gap >= -options.depth)
    return inside


def _free_reach(out: Projection, options: Options) -> FloatArray:
    """`State.reach` of free points by their closest points: zero where those were not found.

    By penetration what lies too deep is as far from contact as from that depth.
    """
    skip = max(options.band, options.depth if options.penetration else 0.0)
    reach = np.where(
        out.gap > 0.0,
        np.maximum(out.gap - options.band, 0.0),
        -np.maximum(-out.gap - skip, 0.0),
    )
    return np.where(out.status == Status.OK, reach, 0.0)
