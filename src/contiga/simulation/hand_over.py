"""How points that share a force hand it on, and by how much they may be early or late in it.

The deepest point carries the force of a law that acts as one; those nearly as deep share it. Two
nodes change over while the difference of their depths goes through a small part of the depth: so
small errors of place make large ones of what each carries, and a node that is let go too early
leaves with another velocity. Each hand-over multiplies what was wrong before it, at any step. With
a the acceleration of a node and d the speed at which depths part, a step h leaves bounds of

    place     x ← x + h v + h² |Δa|/24        the error of a leapfrog itself: ω²h²/24 in phase
    time      τ = x/d                         by which the hand-over is early or late
    velocity  v ← v + |Δa| min(τ, h)          what was handed over, for so long

(small errors carried along; Hairer, Lubich, Wanner, Geometric Numerical Integration, ch. IX, has
the first).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import length, row_products
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.rigid.frames import to_world
from contiga.rigid.rigid_lanes import CENTRE, FORCE, MASS, MOMENTS, TORQUE
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.place import change_of_nodes
from contiga.simulation.system_state import SystemState

OWN = 1.0 / 24.0
"""Of h² |Δa|: what the place of a node is off by after a step."""


class HandOver(NamedTuple):
    """What points that share a force do in a step, and what they may be off by after it."""

    place: float = 0.0
    """Error of the depths of nodes, length."""
    speed: float = 0.0
    """And of how fast these change, length/time."""
    late: float = 0.0
    """Time by which a hand-over in this step is early or late; 0 where there is none."""
    parting: float = math.inf
    """√m times the speed at which depths of points that share a force part, m the mass of what they
    move; infinite where none share."""


def hand_over(model: Model, last: SystemState, state: SystemState) -> HandOver:
    """The errors after a step from `last`, which holds those before it."""
    place = last.place_error + state.step * last.speed_error
    speed, late, parts = last.speed_error, 0.0, []
    for part in model.contacts if state.step > 0.0 else ():
        if not getattr(part.contact.law, "acts_as_one", False):
            continue
        parting = _parting(last.contacts[part.name], state.contacts[part.name], state.step)
        if parting is not None:
            parts.append(parting * math.sqrt(_mass(model, part)))
        change = _change(model, part, last, state)
        if change == 0.0:
            continue
        place += OWN * state.step * state.step * change
        if parting:
            late = max(late, place / parting)
            speed += change * min(late, state.step)
    return HandOver(place, speed, late, max(parts, default=math.inf))


def _mass(model: Model, part: ContactPart) -> float:
    """The least mass that a contact moves at either side; 0 where it moves none."""
    system = model.mechanism
    rows = system.free_sides(part.master, part.slave)
    masses = [float(system.fixed[row, MASS]) for row in rows]
    if part.slave in system.masses:
        masses.append(float(system.masses[part.slave].sum()))
    return min(masses, default=0.0)


def _change(model: Model, part: ContactPart, last: SystemState, state: SystemState) -> float:
    """The largest change in the step of the acceleration of a point of the contact, by what is free
    at either side of it."""
    now = state.contacts[part.name]
    if not (last.contacts[part.name].n_contact or now.n_contact):
        return 0.0
    rows = model.mechanism.free_sides(part.master, part.slave)
    changes = [_change_of_body(model, row, now, last, state) for row in rows]
    if part.slave in model.mechanism.loose:
        mass = model.mechanism.loose[part.slave]
        change = change_of_nodes(model, part.slave, last, state)
        changes.append(float((np.sqrt(np.square(change).sum(axis=1)) / mass).max()))
    return sum(changes)


def _change_of_body(
    model: Model, row: int, now: State, last: SystemState, state: SystemState
) -> float:
    """Of the points in contact as points of a free body: by its force, and by its torque."""
    fixed, lanes = model.mechanism.fixed[row], state.rigid[row]
    change = lanes - last.rigid[row]
    places = to_world(now.pose, now.points_B[now.in_contact])
    arm = length(np.abs(places - lanes[CENTRE : CENTRE + 3]).max(axis=0, initial=0.0))
    turns = length(change[TORQUE : TORQUE + 3]) * arm / fixed[MOMENTS]
    return float(length(change[FORCE : FORCE + 3]) / fixed[MASS] + turns)


def _parting(before: State, now: State, step: float) -> float | None:
    """How fast the depths of points part that share a force, or hand it on; None where one has it
    alone."""
    kept = kept_of(now)
    loaded = [part.nonzero("normal_force")[0] for part in (kept_of(before), kept)]
    rows = np.union1d(*loaded)
    rows = rows[now.in_contact[rows]]
    if len(rows) < 2:
        return None
    way = now.points_B[rows] - before.points_B[rows]
    inward = row_products(way, kept.part("normal_B", rows)) / step
    parting = float(np.ptp(inward))
    return parting if math.isfinite(parting) else None
