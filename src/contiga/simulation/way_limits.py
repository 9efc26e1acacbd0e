"""How far points may go against their masters in one step: not past a wall that they never felt."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from contiga.arrays.ordered import row_products
from contiga.contact.foot_rows import closest
from contiga.contact.state import State
from contiga.records import FloatArray
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.reasons import Cut, Reason
from contiga.simulation.system_state import SystemState

SPAN = 0.02
"""Part of its master's size that a slave may go in a step, where it may touch."""
AIM = 0.9
"""Part of the way that was allowed which the next try takes."""
LEAST_PART = 0.1
"""Part of a step that the next try takes at least."""
CLIPPED = 0.01
"""Part of its way in the step: a point that grazes no deeper has felt nothing."""
STEEP = 0.05
"""Part of its way inside: one that is so deep half way does not graze, however short that is."""


def driven_ways(model: Model, most: float, state: SystemState) -> Iterator[Cut]:
    """The steps after `state`, below `most`, in which points that a motion drives go as far as they
    may."""
    for part in model.contacts:
        if part.name in model.driven_contacts and (speed := _speed(part, state)) > 0.0:
            before = state.contacts[part.name]
            room = _room(model, part, before, np.full(len(before.patch), most * speed / AIM))
            step = AIM * float(room.min(initial=math.inf)) / speed
            yield Cut(step, Reason.WAY, f"contact {part.name!r}")


def too_far(model: Model, last: SystemState, state: SystemState) -> Cut | None:
    """The step to take in place of one in which points go too far; None where they do not.

    They may go a small part of the master's size, or as far as they cannot touch it.
    """
    worst, of = 1.0, ""
    for part in model.contacts:
        ways = _ways(model, part, last, state)
        room = _room(model, part, last.contacts[part.name], ways)
        if (far := float(np.max(ways / room, initial=0.0))) > worst:
            worst, of = far, f"contact {part.name!r}"
    if worst == 1.0:
        return None
    return Cut(state.step * max(LEAST_PART, AIM / worst), Reason.WAY, of)


def _room(model: Model, part: ContactPart, before: State, wanted: FloatArray) -> FloatArray:
    """(m,) how far each point may go; of those that want to go farther their distance is asked."""
    master = model.bodies[part.master].body
    known = np.where(before.patch >= 0, 0.0, before.safe_distance)
    # Points that lie inside since the start touch nothing.
    room = np.where(known < 0.0, math.inf, np.maximum(SPAN * master.size, known))
    rows = np.flatnonzero((wanted > room) & (before.patch < 0)).astype(np.int32)
    if len(rows):
        # What is left of a distance known once lessens on any way, also on one that leads away.
        clear = np.zeros(len(room))
        master.surface.safe_distance(before.points_B, rows, clear)
        if part.contact.half_thickness is not None:
            clear -= part.contact.half_thickness
        room = np.maximum(room, clear)
    return room


def _ways(model: Model, part: ContactPart, last: SystemState, state: SystemState) -> FloatArray:
    """(m,) how far points go, as the master sees it."""
    before, now = last.contacts[part.name], state.contacts[part.name]
    ways = _lengths(now.points_B - before.points_B)
    if part.name in model.driven_contacts:
        # What a table drives may turn round, or whole turns, between the ends of a step.
        fastest = max(_speed(part, at) for at in (last, state))
        ways = np.maximum(ways, fastest * state.step)
    return ways


def _speed(part: ContactPart, at: SystemState) -> float:
    """The largest speed of a node against the master."""
    slave, body = at.slaves[part.slave], at.bodies[part.master]
    against = slave.velocities - body.twist.at(body.pose[:3, 3], slave.points)
    return float(np.max(_lengths(against), initial=0.0))


def _lengths(ways: FloatArray) -> FloatArray:
    """(n,) of the rows, zero of those that are not finite."""
    square = row_products(ways, ways)
    return np.asarray(np.sqrt(np.where(np.isfinite(square), square, 0.0)))


def crossed(model: Model, last: SystemState, state: SystemState) -> Cut | None:
    """The step to take in place of one in which a point goes in and out: to where it is inside."""
    least, of = 1.0, ""
    for part in model.contacts:
        share = _first_inside(model, part, last.contacts[part.name], state.contacts[part.name])
        if share < least:
            least, of = share, f"contact {part.name!r}"
    if not of:
        return None
    return Cut(state.step * max(LEAST_PART, least), Reason.CROSSING, of)


def _first_inside(model: Model, part: ContactPart, before: State, now: State) -> float:
    """The least part of its way after which a point is inside that is outside at both ends."""
    surface = model.bodies[part.master].body.surface
    a, b = before.points_B, now.points_B
    way = _lengths(b - a)
    free = (before.patch < 0) & (now.patch < 0) & (before.safe_distance >= 0.0)
    rows = np.flatnonzero(free & (way > before.safe_distance)).astype(np.int32)
    if len(rows) == 0:
        return 1.0
    entry = surface.entries(a, b, rows)
    rows, start = rows[entry.patch >= 0], entry.point[entry.patch >= 0]
    if len(rows) == 0:
        return 1.0
    leaving, sense = surface.last_crossings(a, b, rows)
    out = sense < 0
    rows, start, end = rows[out], start[out], leaving.point[out]
    if len(rows) == 0:
        return 1.0
    middle = 0.5 * (start + end)
    depth = -closest(surface, middle, np.arange(len(rows), dtype=np.int32)).gap
    aim = np.where((depth > 0.0)[:, None], middle, start + CLIPPED * (end - start))
    gone = _lengths(aim - a[rows]) / way[rows]
    # As deep as its way inside is long, or outside again between two walls: through one.
    least = np.minimum(CLIPPED * way[rows], STEEP * _lengths(end - start))
    return float(np.min(gone, initial=1.0, where=(depth > least) | (depth <= 0.0)))
