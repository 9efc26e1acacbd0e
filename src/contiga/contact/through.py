"""Walls that do not let go of what went through them: `through="hold"`.

A point that comes in is held by the wall it came in by: it stays in contact for as long as the
foot followed on that wall has it behind it, whatever else its path has passed. So the first entry
of a free point's path counts, not the last crossing, and on a closed body a point in contact may
lie outside (THROUGH). The wall lets go of it where the followed foot has the point on the free
side, runs over a border, or vanishes: from there on the point is free, and the rest of its path is
a free point's. What no wall holds is left to the search that goes by sides or last crossings
(`followed`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.followed import track
from contiga.contact.foot_rows import blank, closest, continued, take
from contiga.contact.search_records import Options, Rows, StepSearch
from contiga.masters.protocol import Surface
from contiga.records import (
    ByteArray,
    ContactStatus,
    FloatArray,
    IndexArray,
    IntArray,
    Projection,
    rows_of,
    stacked,
)
from contiga.statuses import Status

# How many walls one after the other may let a path out again before it is left to other searches.
WALLS = 8
# How often a way is halved to find where a wall lets go: to 1e-9 of its length.
HALVINGS = 30


class Held(NamedTuple):
    """Points that a wall holds at the end of the step, one row each."""

    rows: IntArray
    feet: Projection
    status: ByteArray
    """What becomes of them, unless they lie outside of a closed body."""


def detect(search: StepSearch, rows: Rows) -> Rows:
    """Tell what becomes of the points that a wall holds; returns the others."""
    surface, step, last, _, options, _ = search
    touching, near = rows
    foot = last.patch[touching], last.uv[touching]
    way = step.before[touching], step.now[touching]
    tracked = track(surface, way, foot, options)
    kept = np.flatnonzero(tracked.keep)
    old = Held(touching[kept], rows_of(tracked.feet, kept), continued(tracked.feet)[kept])
    settled = _settle(search, old)
    # Where a point left does not matter if its path comes in nowhere.
    left = np.flatnonzero(tracked.solved & ~tracked.keep)
    left = left[surface.entries(step.before, step.now, touching[left]).patch >= 0]
    starts = step.before.copy()
    starts[touching[left]] = _let_go(surface, way, foot, left, options)
    free = np.concatenate((touching[left], near))
    free = free[np.isfinite(step.way[free])]
    if options.closed:
        free = free[~surface.clear_ways(step.before, step.now, free)]
    new = _come_in(surface, starts, step.now, free, options)
    settled = np.concatenate((settled, _settle(search, new)))
    return Rows(np.setdiff1d(touching, settled), np.setdiff1d(near, settled))


def _settle(search: StepSearch, held: Held) -> IntArray:
    """Keep points in contact that a wall holds; returns those it is done for.

    Not those that are on the surface of a closed body within rounding, and not inside.
    """
    detected, band, (rows, feet, status) = search.detected, search.options.band, held
    settled, safe_distance = np.ones(len(rows), dtype=bool), np.zeros(len(rows))
    if search.options.closed:
        side, reach = search.surface.sides(search.step.now, rows)
        inside = (side == 0) & (detected.safe_distance[rows] > 0.0)
        side[inside] = -1
        unknown = np.flatnonzero(side == 0)
        truth = closest(search.surface, search.step.now, rows[unknown])
        proved = (truth.status == Status.OK) & (np.abs(truth.gap) > band)
        side[unknown[proved]] = np.sign(truth.gap[proved])
        reach[unknown[proved]] = np.abs(truth.gap[proved])
        settled = (side <= 0) | (feet.gap < -band)
        status = np.where(side > 0, np.int8(ContactStatus.THROUGH), status)
        inner = np.fmax(detected.safe_distance[rows], reach - band)
        safe_distance = np.where(side < 0, inner, 0.0)
    detected.status[rows[settled]] = status[settled]
    detected.safe_distance[rows[settled]] = safe_distance[settled]
    detected.last_patch[rows[settled]] = -1
    take(detected.feet, rows, feet, settled)
    return rows[settled]


def _come_in(
    surface: Surface, starts: FloatArray, now: FloatArray, rows: IntArray, options: Options
) -> Held:
    """Find the points among `rows`, free at `starts`, that a wall holds by which they come in.

    `starts` is changed: to where the last wall that they came in by let go of them.
    """
    held = Held(rows[:0], blank(0), np.zeros(0, np.int8))
    for _ in range(WALLS):
        hits = surface.entries(starts, now, rows)
        hit = np.flatnonzero((hits.patch >= 0) & (hits.status != Status.BUDGET))
        rows, place = rows[hit], (hits.patch[hit], hits.uv[hit])
        if len(rows) == 0:
            break
        way = hits.point[hit], now[rows]
        tracked = track(surface, way, place, options)
        kept = np.flatnonzero(tracked.keep)
        status = np.where(tracked.at_border, ContactStatus.HELD, ContactStatus.NEW)
        held = Held(
            np.concatenate((held.rows, rows[kept])),
            stacked(held.feet, rows_of(tracked.feet, kept)),
            np.concatenate((held.status, status[kept].astype(np.int8))),
        )
        on = np.flatnonzero(tracked.solved & ~tracked.keep)
        starts[rows[on]] = _let_go(surface, way, place, on, options)
        rows = rows[on]
    return held


def _let_go(
    surface: Surface,
    way: tuple[FloatArray, FloatArray],
    place: tuple[IntArray, FloatArray],
    rows: IndexArray,
    options: Options,
) -> FloatArray:
    """Find where (len(rows), 3) the wall first lets go of points that went `way` = (from, to).

    Their feet were at `place` = (patch, uv) where they started, and are kept no more at the end.
    """
    a, b = way[0][rows], way[1][rows]
    start = place[0][rows], place[1][rows]
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    for _ in range(HALVINGS if len(rows) else 0):
        middle = 0.5 * (low + high)
        keep = track(surface, (None, a + middle[:, None] * (b - a)), start, options).keep
        low, high = np.where(keep, middle, low), np.where(keep, high, middle)
    return np.asarray(a + high[:, None] * (b - a))
