"""How fast the forces on bodies change: what a step has to follow, and does not where all rests.

In a step h a leapfrog's velocity is off by about h²/12 of the rate at which the acceleration
changes. A body that swings at ω on what it touches changes it by ω² v: so steps that are to be
right to a share ε of the largest velocity take h = √(12 ε)/ω in an impact, and any length that is
stable at rest, in steady sliding and in rolling, where the forces of single points change and
their sum does not. Elastic forces and friction count, as far as they change smoothly; how hard
damping pulls counts as a swing of a part of its decay.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.contact.state import State
from contiga.num.ordered import product
from contiga.num.rigid import to_world, turn_to_world
from contiga.num.rigid_lanes import AXES, CENTRE, FORCE, MASS, MOMENTS, SPINS, WAYS
from contiga.records import FloatArray
from contiga.simulation.critical import follows_step
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.system_state import SystemState


def shaking_of(model: Model, last: SystemState, state: SystemState, decay: float) -> float:
    """The largest rate of the forces on a free body in the step from `last`, over √mass.

    Rates of turning count by what they would do to the kinetic energy alike. `decay` is that which
    damping forces count with, 1/time.
    """
    system = model.mechanism
    if state.step == 0.0 or not len(system.free):
        return 0.0
    rates = np.zeros((len(system.free), 6))
    for part in model.contacts:
        if not follows_step(part.contact.law):
            _add_contact(rates, system, part, last, state, decay)
    for name in state.springs:
        _add_spring(rates, system, name, last, state, decay)
    return max(_over_mass(system, k, rate, state) for k, rate in enumerate(rates))


def unbalanced(model: Model, state: SystemState) -> float:
    """The largest force on a free body that nothing balances, over √mass, as `shaking_of`."""
    system = model.mechanism
    forces = state.rigid[:, FORCE : FORCE + 6]
    return max((_over_mass(system, k, own, state) for k, own in enumerate(forces)), default=0.0)


def _over_mass(system: Mechanism, k: int, rate: FloatArray, state: SystemState) -> float:
    """√(ṗᵀ M⁻¹ ṗ) of the rate (6,) of force and moment about the centre of a body."""
    one, turn = system.fixed[k], state.bodies.poses[int(system.free[k]), :3, :3]
    own = product(turn.T, rate[3:] * one[SPINS : SPINS + 3])
    moment = product(one[AXES : AXES + 9].reshape(3, 3).T, own)
    square = np.square(rate[:3] * one[WAYS : WAYS + 3]).sum() / one[MASS]
    return math.sqrt(float(square + (moment * moment / one[MOMENTS : MOMENTS + 3]).sum()))


def _add_contact(
    rates: FloatArray,
    system: Mechanism,
    part: ContactPart,
    last: SystemState,
    state: SystemState,
    decay: float,
) -> None:
    """Rates of what a contact does to the free bodies at its two sides."""
    before, now = last.contacts[part.name], state.contacts[part.name]
    changes = _elastic(before, now, state.step, decay), _gripped(before, now, state.step)
    sides = (int(system.root[system.index[part.master]]), -1.0), (system.carried.get(part.slave), 1)
    for side, sign in sides:
        if side is None or side not in system.row:
            continue
        k = system.row[side]
        for places in changes:
            _add(rates[k], places, sign, state.rigid[k, CENTRE : CENTRE + 3])


_Places = tuple[FloatArray, FloatArray]
"""(k, 3) places and (k, 3) forces or their rates there, world axes."""


def _elastic(before: State, now: State, step: float, decay: float) -> _Places:
    """Rates of the normal forces on the slave by stiffness alone: what sets in at once has none."""
    rows = np.flatnonzero(now.stiffness)
    normals, points = now.part("normal_B", rows), now.points_B[rows]
    inward = -((points - before.points_B[rows]) * normals).sum(axis=1) / step
    rate = now.stiffness[rows] * np.where(np.isfinite(inward), inward, 0.0)
    if len(now.damping):
        rate = rate + decay * now.damping[rows]
    return to_world(now.pose, points), turn_to_world(now.pose, rate[:, None] * normals)


def _gripped(before: State, now: State, step: float) -> _Places:
    """Rates of friction, of the points that carried before: what others have is their first."""
    rows, traction = now.listed("traction_B")
    if len(rows):
        carried = (now.part("normal_force", rows) > 0.0) & (before.part("normal_force", rows) > 0.0)
        rows, traction = rows[carried], traction[carried]
    if len(rows) == 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    rate = (traction - before.part("traction_B", rows)) / step
    return to_world(now.pose, now.points_B[rows]), turn_to_world(now.pose, rate)


def _add(rate: FloatArray, places: _Places, factor: float, centre: FloatArray) -> None:
    points, forces = places
    rate[:3] += factor * forces.sum(axis=0)
    rate[3:] += factor * np.cross(points - centre, forces).sum(axis=0)


def _add_spring(
    rates: FloatArray,
    system: Mechanism,
    name: str,
    last: SystemState,
    state: SystemState,
    decay: float,
) -> None:
    """Rates of what a spring does to the free bodies at its two ends."""
    both = [(last.springs[name], -1.0, last), (state.springs[name], 1.0, state)]
    for end, body in enumerate(system.springs[name].between):
        number = system.number(body)
        if number is None or number not in system.row:
            continue
        k = system.row[number]
        for spring, sign, at in both:
            if spring.length == 0.0:
                continue
            axis = (spring.ends[1 - end] - spring.ends[end]) / spring.length
            size = sign * (spring.force - spring.damper) / state.step
            if sign > 0.0:
                size += decay * spring.damper
            place = spring.ends[end : end + 1], (size * axis)[None]
            _add(rates[k], place, 1.0, at.rigid[k, CENTRE : CENTRE + 3])
