"""The search for points of shells with a thickness: in contact where half of it reaches.

A point x of the mid-surface is in contact where its distance d(x) from the body, negative inside,
is below half the thickness h there, and h − d is the penetration. So a shell is what balls of
radius h sweep over: it has no front, stands off edges as off faces, and the energy of contact is a
function of the places alone. What decides is where points are at the end of a step, not the way
they came: their walls are the nearest ones. Of an open body, which has a front but no inside, a
search by intersection takes only points that come from in front of it, out of reach.

Feet are told on the surface that is h off the body, so that all that follows the search is as of
points without a thickness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.area.offset import off_surface
from contiga.contact.foot_rows import closest, take
from contiga.contact.search_records import BoolArray, Detected, Options, Rows, StepSearch
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


class Reached(NamedTuple):
    """Points, one row each, and what half the thickness there reaches."""

    feet: Projection
    """On the surface that is half the thickness off."""
    within: BoolArray
    """Near enough for contact."""
    solved: BoolArray
    """Whose closest point is known."""
    on_border: BoolArray
    """Whose closest point is on a border of an open body."""
    behind: BoolArray
    """That lie behind the body, or inside."""
    room: FloatArray
    """Least way to contact, length; for points within reach minus the least way out of it."""


def detect_at_start(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> None:
    """Search at the start.

    By intersection, points within reach are not in contact until they have been out of it; by
    penetration they are.
    """
    near = _near(surface, p_B, rows, detected, options)
    reached = reach(closest(surface, p_B, near), p_B, near, options)
    detected.safe_distance[near] = reached.room
    if options.penetration:
        touching = reached.within & (options.hold | ~reached.on_border)
        detected.status[near[touching]] = ContactStatus.NEW
        detected.safe_distance[near[reached.within]] = 0.0
        take(detected.feet, near, reached.feet, touching)


def detect(search: StepSearch, rows: Rows) -> None:
    """Tell what becomes of the points that were in contact and the free ones that are near."""
    surface, step, _, detected, options, _ = search
    were, free = rows
    near = np.concatenate((were, _near(surface, step.now, free, detected, options)))
    was = np.arange(len(near)) < len(were)
    reached = reach(_feet(search, near), step.now, near, options)
    beside = reached.on_border & (not options.hold)
    touching = reached.within & ~beside
    past = np.isfinite(step.way[near]) | options.penetration
    touching &= was | (past & ~step.ignored[near])
    if not options.closed:
        _leave_from_behind(search, near, was, reached, touching)
    # By penetration they are in contact as soon as they are over a face.
    seen = reached.within & beside & options.penetration
    held = touching & reached.on_border
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[was & reached.within & beside] = ContactStatus.SLID_OFF
    status[touching] = np.where(was[touching], ContactStatus.OLD, ContactStatus.NEW)
    status[held] = ContactStatus.HELD
    status[~reached.solved] = ContactStatus.LOST
    detected.status[near] = status
    detected.safe_distance[near] = np.where(touching | seen, 0.0, reached.room)
    take(detected.feet, near, reached.feet, touching)


def _leave_from_behind(
    search: StepSearch, near: IntArray, was: BoolArray, reached: Reached, touching: BoolArray
) -> None:
    """Take those points out of `touching` that came to an open body from behind or beside it.

    New ones must have been in front, out of reach. Those in contact must not come behind the
    surface from beyond its border, where they were as deep as they are now far.
    """
    options = search.options
    new = touching & ~was & (not options.penetration)
    unsure = np.flatnonzero(new | (touching & was & reached.behind & ~reached.on_border))
    if len(unsure) == 0:
        return
    rows = near[unsure]
    before = reach(_feet(search, rows, before=True), search.step.before, rows, options)
    ahead = before.solved & ~before.behind & (before.room >= 0.0)
    touching[unsure] = np.where(was[unsure], ~before.on_border, ahead)


def _feet(search: StepSearch, rows: IntArray, *, before: bool = False) -> Projection:
    """Find the closest points of points `rows`, now or before the step.

    On a surface that changes its shape the search starts from the feet of the last step.
    """
    step, shape, last = search.step, search.shape, search.last
    points = step.before if before else step.now
    if shape is None:
        return closest(search.surface, points, rows)
    out, surface = empty_projection(len(rows)), shape.surface_before if before else shape.surface
    surface.closest_from(SurfacePlaces(last.patch[rows], last.uv[rows]), points[rows], out)
    return out


def reach(feet: Projection, p_B: FloatArray, rows: IntArray, options: Options) -> Reached:
    """Find from the closest points of p_B[rows] which points are within half the thickness."""
    assert options.half is not None
    half = options.half[rows]
    on_border = (feet.status == Status.BORDER) | (feet.status == Status.TRIMMED)
    solved = (feet.status == Status.OK) | on_border
    # Beside a border there is no inside.
    distance = np.where(on_border, np.abs(feet.gap), feet.gap)
    within = solved & (distance <= half) & (distance >= -options.depth)
    room = np.maximum(distance - half, -distance - options.depth)
    # By no more than rounding within reach is as good as out of it.
    deep = within & (room < -options.band)
    room[~deep] = np.maximum(room[~deep] - options.band, 0.0)
    room[~solved] = 0.0
    off = off_surface(feet, p_B[rows], half, options.band)
    return Reached(off, within, solved, on_border, solved & (feet.gap < 0.0), room)


def _near(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> IntArray:
    """Return the rows whose closest points are needed; write the others' distance from contact."""
    assert options.half is not None
    if options.closed:
        known = surface.sides(p_B, rows)
        outside, length = known.side > 0, known.reach
    else:
        length = np.zeros(len(p_B))
        surface.safe_distance(p_B, rows, length)
        length, outside = length[rows], np.ones(len(rows), np.bool_)
        length = length - np.maximum(options.depth - options.half[rows], 0.0)
    clear = outside & (length > options.half[rows] + options.band)
    detected.safe_distance[rows[clear]] = (length - options.half[rows])[clear] - options.band
    return rows[~clear]
