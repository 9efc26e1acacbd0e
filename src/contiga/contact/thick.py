"""Search for points of shells with a thickness: contact begins at half the thickness.

A point x of the mid-surface is in contact if its distance d(x) from the body, negative inside, is
below half the thickness h; its penetration is h − d. The shell is thus the union of balls of radius
h: it has no front, stands off edges as off faces, and the energy of contact depends on positions
alone. Positions at the end of a step decide, not paths, and the nearest walls push. On an open
body, which has a front but no inside, a search by intersection takes only points that come from in
front of it, from out of reach.

Feet are returned on the surface at the distance h from the body, so that everything after the
search works as for points without a thickness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.area.offset import off_surface
from contiga.contact.foot_rows import at_border, closest, copy_feet
from contiga.contact.search_records import BoolArray, Detection, Options, Rows, StepSearch
from contiga.masters.protocol import Surface
from contiga.records import (
    ContactStatus,
    FloatArray,
    IntArray,
    Projection,
    SurfacePlaces,
    empty_projection,
)
from contiga.statuses import Status


class Reach(NamedTuple):
    """Distances of points from contact, one row each."""

    feet: Projection
    """Feet on the surface at half the thickness from the body."""
    within: BoolArray
    """Whether a point is near enough for contact."""
    solved: BoolArray
    """Whether the closest point is known."""
    on_border: BoolArray
    """Whether the closest point is on a border of an open body."""
    behind: BoolArray
    """Whether a point is behind the body, or inside."""
    room: FloatArray
    """Distance from contact, length; for points in reach minus the distance to leave it."""


def detect_at_start(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detection, options: Options
) -> None:
    """Write the results at the start into `detected`, of points `rows` of p_B (n, 3), body axes.

    In a search by intersection points within reach are not in contact until they have been out of
    reach; in a search by penetration they are, unless the border is their closest point and does
    not hold them.
    """
    rows_near = _rows_within_reach(surface, p_B, rows, detected, options)
    reached = measure_reach(closest(surface, p_B, rows_near), p_B, rows_near, options)
    detected.safe_distance[rows_near] = reached.room
    if options.penetration:
        touching = reached.within & (options.hold | ~reached.on_border)
        detected.status[rows_near[touching]] = ContactStatus.NEW
        detected.safe_distance[rows_near[reached.within]] = 0.0
        copy_feet(detected.feet, rows_near, reached.feet, touching)


def detect(search: StepSearch, rows: Rows) -> None:
    """Write the decision on the points of `rows` into `search.detected`.

    A point in contact stays as long as it is within reach; a free one enters by coming within
    reach, of an open body from the front, if it has been out of reach since the start. In a search
    by penetration it enters wherever it comes from.
    """
    surface, step, _, detected, options, _ = search
    touching_before, free = rows
    rows_near = np.concatenate(
        (touching_before, _rows_within_reach(surface, step.now, free, detected, options))
    )
    was_touching = np.arange(len(rows_near)) < len(touching_before)
    reached = measure_reach(_closest_points(search, rows_near), step.now, rows_near, options)
    slides_off = reached.on_border & (not options.hold)
    touching = reached.within & ~slides_off
    has_past = np.isfinite(step.path_length[rows_near]) | options.penetration
    touching &= was_touching | (has_past & ~step.inside_since_start[rows_near])
    if not options.closed:
        _exclude_from_behind(search, rows_near, was_touching, reached, touching)
    # In a search by penetration these are in contact as soon as they are over a face.
    is_near_edge = reached.within & slides_off & options.penetration
    is_held = touching & reached.on_border
    status = np.where(was_touching, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[was_touching & reached.within & slides_off] = ContactStatus.SLID_OFF
    status[touching] = np.where(was_touching[touching], ContactStatus.OLD, ContactStatus.NEW)
    status[is_held] = ContactStatus.HELD
    status[~reached.solved] = ContactStatus.LOST
    detected.status[rows_near] = status
    detected.safe_distance[rows_near] = np.where(touching | is_near_edge, 0.0, reached.room)
    copy_feet(detected.feet, rows_near, reached.feet, touching)


def _exclude_from_behind(
    search: StepSearch,
    rows_near: IntArray,
    was_touching: BoolArray,
    reached: Reach,
    touching: BoolArray,
) -> None:
    """Exclude points from `touching` that came to an open body from behind or beside it.

    New points must have been in front, out of reach. Points in contact must not come behind the
    surface from beyond its border.
    """
    options = search.options
    is_new = touching & ~was_touching & (not options.penetration)
    unsure = np.flatnonzero(
        is_new | (touching & was_touching & reached.behind & ~reached.on_border)
    )
    if len(unsure) == 0:
        return
    rows = rows_near[unsure]
    before = measure_reach(
        _closest_points(search, rows, before=True), search.step.before, rows, options
    )
    was_in_front = before.solved & ~before.behind & (before.room >= 0.0)
    touching[unsure] = np.where(was_touching[unsure], ~before.on_border, was_in_front)


def _closest_points(search: StepSearch, rows: IntArray, *, before: bool = False) -> Projection:
    """Return the closest points of points `rows`, one row each, now or before the step.

    On a surface that changes its shape the search starts from the feet of the last step.
    """
    step, shape, last = search.step, search.shape, search.last
    points = step.before if before else step.now
    if shape is None:
        return closest(search.surface, points, rows)
    out, surface = empty_projection(len(rows)), shape.surface_before if before else shape.surface
    surface.closest_from(SurfacePlaces(last.patch[rows], last.uv[rows]), points[rows], out)
    return out


def measure_reach(feet: Projection, p_B: FloatArray, rows: IntArray, options: Options) -> Reach:
    """Return the distances from contact of p_B[rows] by their closest points.

    Beyond a border the distance counts as in front. The `room` of points without a closest point is
    zero.
    """
    assert options.half is not None
    half = options.half[rows]
    on_border = at_border(feet)
    solved = (feet.status == Status.OK) | on_border
    # Beyond a border there is no inside.
    distance = np.where(on_border, np.abs(feet.gap), feet.gap)
    within = solved & (distance <= half) & (distance >= -options.depth)
    room = np.maximum(distance - half, -distance - options.depth)
    # Within reach by no more than rounding counts as out of reach.
    deep = within & (room < -options.band)
    room[~deep] = np.maximum(room[~deep] - options.band, 0.0)
    room[~solved] = 0.0
    shifted = off_surface(feet, p_B[rows], half, options.band)
    return Reach(shifted, within, solved, on_border, solved & (feet.gap < 0.0), room)


def _rows_within_reach(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detection, options: Options
) -> IntArray:
    """Return the rows that may be within reach; write safe distances of the others to `detected`.

    A bound of the distance above half the thickness, outside a closed body, proves the others.
    """
    assert options.half is not None
    if options.closed:
        sides = surface.sides(p_B, rows)
        outside, distance = sides.side > 0, sides.reach
    else:
        distance = np.zeros(len(p_B))
        surface.safe_distance(p_B, rows, distance)
        distance, outside = distance[rows], np.ones(len(rows), np.bool_)
        distance = distance - np.maximum(options.depth - options.half[rows], 0.0)
    is_clear = outside & (distance > options.half[rows] + options.band)
    detected.safe_distance[rows[is_clear]] = (distance - options.half[rows])[
        is_clear
    ] - options.band
    return rows[~is_clear]
