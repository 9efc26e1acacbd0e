"""Hold points that tunnelled at the wall by which they entered: `through="hold"`.

A point stays in contact as long as it is behind its foot on that wall, whatever its path has passed
since. So the first entry of a free point's path counts, not the last crossing, and on a closed body
a point in contact may be outside (THROUGH). The wall releases the point where the followed foot has
it on the free side, passes a border, or vanishes; for the remaining path the point is free. Points
that no wall holds are left to the search by sides or last crossings (`followed`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.followed import track
from contiga.contact.foot_rows import blank, closest, copy_feet, kept_statuses
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

# Largest number of walls that a path may enter and leave before it is left to other searches.
MAX_WALLS = 8
# Halvings of a path to find where a wall releases a point: to 1e-9 of its length.
N_HALVINGS = 30


class Held(NamedTuple):
    """Points held by a wall at the end of the step, one row each."""

    rows: IntArray
    feet: Projection
    status: ByteArray
    """Their statuses, unless they are outside a closed body."""


def detect(search: StepSearch, rows: Rows) -> Rows:
    """Write results of the points that a wall holds into `search.detected`; return the others.

    The others are ascending. Free points, and points released on their path, are held by the wall
    by which they enter next.
    """
    surface, step, last, _, options, _ = search
    touching, free_before = rows
    foot = last.patch[touching], last.uv[touching]
    path = step.before[touching], step.now[touching]
    tracked = track(surface, path, foot, options)
    kept_rows = np.flatnonzero(tracked.keep)
    old = Held(
        touching[kept_rows],
        rows_of(tracked.feet, kept_rows),
        kept_statuses(tracked.feet)[kept_rows],
    )
    settled = _keep_held(search, old)
    # The release point matters only for paths that enter the body again.
    released = np.flatnonzero(tracked.solved & ~tracked.keep)
    released = released[surface.entries(step.before, step.now, touching[released]).patch >= 0]
    starts = step.before.copy()
    starts[touching[released]] = _release_points(surface, path, foot, released, options)
    free = np.concatenate((touching[released], free_before))
    free = free[np.isfinite(step.path_length[free])]
    if options.closed:
        free = free[~surface.clear_paths(step.before, step.now, free)]
    new = _find_held_entries(surface, starts, step.now, free, options)
    settled = np.concatenate((settled, _keep_held(search, new)))
    return Rows(np.setdiff1d(touching, settled), np.setdiff1d(free_before, settled))


def _keep_held(search: StepSearch, held: Held) -> IntArray:
    """Keep held points in contact; return the rows for which this decides.

    Their statuses, safe distances and feet are written into `search.detected`. Points outside a
    closed body become THROUGH if they are behind their feet by more than rounding; other points
    outside are left undecided.
    """
    detected, band, (rows, feet, status) = search.detected, search.options.band, held
    settled, safe_distance = np.ones(len(rows), dtype=bool), np.zeros(len(rows))
    if search.options.closed:
        side, reach = search.surface.sides(search.step.now, rows)
        was_inside = (side == 0) & (detected.safe_distance[rows] > 0.0)
        side[was_inside] = -1
        unsure = np.flatnonzero(side == 0)
        closest_points = closest(search.surface, search.step.now, rows[unsure])
        is_proved = (closest_points.status == Status.OK) & (np.abs(closest_points.gap) > band)
        side[unsure[is_proved]] = np.sign(closest_points.gap[is_proved])
        reach[unsure[is_proved]] = np.abs(closest_points.gap[is_proved])
        settled = (side <= 0) | (feet.gap < -band)
        status = np.where(side > 0, np.int8(ContactStatus.THROUGH), status)
        inner_distance = np.fmax(detected.safe_distance[rows], reach - band)
        safe_distance = np.where(side < 0, inner_distance, 0.0)
    detected.status[rows[settled]] = status[settled]
    detected.safe_distance[rows[settled]] = safe_distance[settled]
    detected.last_patch[rows[settled]] = -1
    copy_feet(detected.feet, rows, feet, settled)
    return rows[settled]


def _find_held_entries(
    surface: Surface, starts: FloatArray, now: FloatArray, rows: IntArray, options: Options
) -> Held:
    """Return the points among `rows`, free at `starts`, that a wall of entry holds at the end.

    Up to `MAX_WALLS` walls are tried, one after the other. `starts` is changed to where the last
    wall of entry released each point.
    """
    result = Held(rows[:0], blank(0), np.zeros(0, np.int8))
    for _ in range(MAX_WALLS):
        hits = surface.entries(starts, now, rows)
        entering = np.flatnonzero((hits.patch >= 0) & (hits.status != Status.BUDGET))
        rows, place = rows[entering], (hits.patch[entering], hits.uv[entering])
        if len(rows) == 0:
            break
        path = hits.point[entering], now[rows]
        tracked = track(surface, path, place, options)
        kept_rows = np.flatnonzero(tracked.keep)
        status = np.where(tracked.at_border, ContactStatus.HELD, ContactStatus.NEW)
        result = Held(
            np.concatenate((result.rows, rows[kept_rows])),
            stacked(result.feet, rows_of(tracked.feet, kept_rows)),
            np.concatenate((result.status, status[kept_rows].astype(np.int8))),
        )
        passed = np.flatnonzero(tracked.solved & ~tracked.keep)
        starts[rows[passed]] = _release_points(surface, path, place, passed, options)
        rows = rows[passed]
    return result


def _release_points(
    surface: Surface,
    path: tuple[FloatArray, FloatArray],
    place: tuple[IntArray, FloatArray],
    rows: IndexArray,
    options: Options,
) -> FloatArray:
    """Return where (len(rows), 3) the wall releases points on `path` = (from, to), by bisection.

    Their feet are at `place` = (patch, uv) at the start, and are not kept at the end. The result is
    that end of the last bracket at which a point is not held.
    """
    a, b = path[0][rows], path[1][rows]
    start = place[0][rows], place[1][rows]
    low, high = np.zeros(len(rows)), np.ones(len(rows))
    for _ in range(N_HALVINGS if len(rows) else 0):
        middle = 0.5 * (low + high)
        keep = track(surface, (None, a + middle[:, None] * (b - a)), start, options).keep
        low, high = np.where(keep, middle, low), np.where(keep, high, middle)
    return np.asarray(a + high[:, None] * (b - a))
