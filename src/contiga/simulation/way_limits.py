"""How far points may go against their masters in one step: not past a wall that they never felt."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from contiga.contact.state import State
from contiga.contact.tracked import closest
from contiga.dynamics.prescribed import Fixed, Moved
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
"""Part of its way in the step: a point that goes no deeper and out again has felt nothing."""


def driven_ways(model: Model, state: SystemState) -> Iterator[Cut]:
    """The steps after `state` in which points that a motion drives go as far as they may."""
    for part in model.contacts:
        if _driven(model, part) and (speed := _speed(part, state)) > 0.0:
            allowed = _allowed(model, part, state.contacts[part.name])
            yield Cut(AIM * allowed / speed, Reason.WAY, f"contact {part.name!r}")


def too_far(model: Model, last: SystemState, state: SystemState) -> Cut | None:
    """The step to take in place of one in which points go too far; None where they do not.

    They may go a small part of the master's size; or, of a slave that is clear of it, as far as no
    point of it can touch.
    """
    worst, of = 1.0, ""
    for part in model.contacts:
        allowed = _allowed(model, part, last.contacts[part.name])
        if math.isfinite(allowed) and (far := _way(model, part, last, state) / allowed) > worst:
            worst, of = far, f"contact {part.name!r}"
    if worst == 1.0:
        return None
    return Cut(state.step * max(LEAST_PART, AIM / worst), Reason.WAY, of)


def _allowed(model: Model, part: ContactPart, before: State) -> float:
    """How far points may go."""
    return max(SPAN * model.bodies[part.master].body.size, _clear(before))


def _clear(state: State) -> float:
    """How far all points can go before the first can touch; 0 where one is in contact."""
    if state.n_contact:
        return 0.0
    return float(state.safe_distance.min(initial=math.inf, where=state.safe_distance >= 0.0))


def _way(model: Model, part: ContactPart, last: SystemState, state: SystemState) -> float:
    """The longest way of a point, as the master sees it."""
    before, now = last.contacts[part.name], state.contacts[part.name]
    most = float(np.max(_lengths(now.points_B - before.points_B), initial=0.0))
    if _driven(model, part):
        # What a table drives may turn round, or whole turns, between the ends of a step.
        fastest = max(_speed(part, at) for at in (last, state))
        most = max(most, fastest * state.step)
    return most


def _driven(model: Model, part: ContactPart) -> bool:
    """Whether a motion that is prescribed moves one of the two sides."""
    system = model.mechanism
    driven, host = {i for _, _, i in system.driven}, system.carried.get(part.slave)
    if int(system.root[system.index[part.master]]) in driven or host in driven:
        return True
    if host is not None or part.slave in system.masses:
        return False
    motion = model.slaves[part.slave].motion
    return not (
        isinstance(motion, Moved)
        and isinstance(motion.motion, Fixed)
        and isinstance(motion.base, np.ndarray)
    )


def _speed(part: ContactPart, at: SystemState) -> float:
    """The largest speed of a node against the master."""
    (points, velocities), body = at.slaves[part.slave], at.bodies[part.master]
    return float(
        np.max(_lengths(velocities - body.twist.at(body.pose[:3, 3], points)), initial=0.0)
    )


def _lengths(ways: FloatArray) -> FloatArray:
    """(n,) of the rows, zero of those that are not finite."""
    square = (ways * ways).sum(axis=1)
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
    rows, middle = rows[out], 0.5 * (start[out] + leaving.point[out])
    if len(rows) == 0:
        return 1.0
    depth = -closest(surface, middle, np.arange(len(rows), dtype=np.int32)).gap
    felt = depth > CLIPPED * way[rows]
    gone = _lengths(middle - a[rows]) / way[rows]
    return float(np.min(gone, initial=1.0, where=felt))
