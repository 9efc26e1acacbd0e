"""The search for points of shells with a thickness: in contact where half of it reaches.

A point x of the mid-surface is in contact where its distance d(x) from the body, negative inside,
is below half the thickness h there, and h − d is the penetration. So a shell is what balls of
radius h sweep over: it has no front, stands off edges as off faces, and the energy of contact is a
function of the places alone. What decides is where points are at the end of a step, not the way
they came: their walls are the nearest ones.

Feet are told on the surface that is h off the body, so that all that follows the search is as of
points without a thickness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.contact.tracked import (
    BoolArray,
    Detected,
    Options,
    Step,
    closest,
    take,
)
from contiga.masters.protocol import Surface
from contiga.records import ContactStatus, FloatArray, IntArray, Projection
from contiga.statuses import Status


class Reached(NamedTuple):
    """Points, one row each, and what half the thickness there reaches."""

    feet: Projection
    """On the surface that is half the thickness off."""
    touching: BoolArray
    solved: BoolArray
    """Whose closest point is known."""
    beside: BoolArray
    """Near enough, but beside a border that does not hold them."""
    room: FloatArray
    """Way to contact at least; of points in contact how deep they are, below zero."""


def detect_at_start(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> None:
    """The start: by intersection points within reach are not in contact until they have been out of
    it; by penetration they are."""
    near = _near(surface, p_B, rows, detected, options)
    reached = reach(surface, p_B, near, options)
    detected.safe_distance[near] = reached.room
    if options.penetration:
        detected.status[near[reached.touching]] = ContactStatus.NEW
        detected.safe_distance[near[reached.touching]] = 0.0
        take(detected.feet, near, reached.feet, reached.touching)


def detect(
    surface: Surface,
    step: Step,
    rows: tuple[IntArray, IntArray],
    detected: Detected,
    options: Options,
) -> None:
    """Fill `detected` for the points that were in contact and the free ones that are near."""
    were, free = rows
    near = np.concatenate((were, _near(surface, step.now, free, detected, options)))
    was = np.arange(len(near)) < len(were)
    reached = reach(surface, step.now, near, options)
    # What is within reach since the start comes in when it has been out of it.
    touching = reached.touching & (was | ~step.ignored[near] | options.penetration)
    status = np.where(was, ContactStatus.RELEASED, ContactStatus.FREE).astype(np.int8)
    status[was & reached.beside] = ContactStatus.SLID_OFF
    status[touching] = np.where(was[touching], ContactStatus.OLD, ContactStatus.NEW)
    status[~reached.solved] = ContactStatus.LOST
    detected.status[near] = status
    detected.safe_distance[near] = np.where(touching, 0.0, reached.room)
    take(detected.feet, near, reached.feet, touching)


def reach(surface: Surface, p_B: FloatArray, rows: IntArray, options: Options) -> Reached:
    """What becomes of points by their closest points."""
    assert options.half is not None
    half, feet = options.half[rows], closest(surface, p_B, rows)
    on_border = (feet.status == Status.BORDER) | (feet.status == Status.TRIMMED)
    solved = (feet.status == Status.OK) | on_border
    # Beside a border there is no inside.
    distance = np.where(on_border, np.abs(feet.gap), feet.gap)
    within = solved & (distance < half) & (distance >= -options.depth)
    beside = within & on_border & (not options.hold)
    normal, away = feet.normal.copy(), np.abs(distance) > options.band
    normal[away] = (p_B[rows] - feet.point)[away] / distance[away, None]
    room = np.maximum(distance - half, -distance - options.depth) - options.band
    room[within] = (distance - half)[within]
    room[beside | ~solved] = 0.0
    off = feet._replace(
        point=feet.point + half[:, None] * normal, normal=normal, gap=distance - half
    )
    return Reached(off, within & ~beside, solved, beside, room)


def _near(
    surface: Surface, p_B: FloatArray, rows: IntArray, detected: Detected, options: Options
) -> IntArray:
    """Those of the rows whose closest points have to be looked for; how far the others are from
    contact is told."""
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
