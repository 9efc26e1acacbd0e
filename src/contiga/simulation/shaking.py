"""How fast the forces on bodies change: what a step has to follow, and does not where all rests.

In a step h a leapfrog's velocity is off by about h²/12 of the rate at which the acceleration
changes. A body that swings at ω on what it touches changes it by ω² v: so steps that are to be
right to a share ε of the largest velocity take h = √(12 ε)/ω in an impact, and any length that is
stable at rest, in steady sliding and in rolling, where the forces of single points change and
their sum does not. Elastic forces and friction count, as far as they change smoothly; how hard
damping pulls counts as a swing of a part of its decay. Free nodes count all together, and are
followed less closely: there may be many, and what each does is seldom asked for.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from contiga.arrays.ordered import product, row_products
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.laws.friction import ViscousFriction
from contiga.records import FloatArray, IndexArray
from contiga.rigid.frames import to_world, turn_to_world
from contiga.rigid.rigid_lanes import AXES, CENTRE, FORCE, MASS, MOMENTS, SPINS, WAYS
from contiga.simulation.critical import follows_step
from contiga.simulation.forces import add_forces
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import ContactPart, Model
from contiga.simulation.place import change_of_nodes
from contiga.simulation.system_state import SystemState


class _Felt(NamedTuple):
    """Forces, or their rates, at some points of a contact."""

    rows: IndexArray
    """(k,) points of contact."""
    forces: FloatArray
    """(k, 3) on the slave, world axes."""


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
            for felt in _rates(part, last, state, decay):
                _add_felt(rates, system, part, felt, state)
    for name in state.springs:
        _add_spring(rates, system, name, last, state, decay)
    return max(_over_mass(system, k, rate, state) for k, rate in enumerate(rates))


def shaking_of_nodes(model: Model, last: SystemState, state: SystemState, decay: float) -> float:
    """The same of the free nodes of a slave, all together."""
    most = 0.0
    for name, mass in model.mechanism.loose.items() if state.step > 0.0 else ():
        rates = np.zeros((len(mass), 3))
        for part in model.contacts:
            if part.slave != name or follows_step(part.contact.law):
                continue
            for felt in _rates(part, last, state, decay):
                for k, values in enumerate(felt.forces.T):
                    nodes, sums = part.contact.nodal_sum(felt.rows, np.ascontiguousarray(values))
                    rates[nodes, k] += sums
        most = max(most, math.sqrt(float((np.square(rates).sum(axis=1) / mass).sum())))
    return most


def dragging_of(model: Model, last: SystemState, state: SystemState) -> float:
    """The largest rate at which the viscous friction of a contact changes, over what it can be at
    most; 1/time."""
    most = 0.0
    for part in model.contacts if state.step > 0.0 else ():
        friction, now = part.contact.friction, state.contacts[part.name]
        if isinstance(friction, ViscousFriction):
            rates = _gripped(last.contacts[part.name], now, state.step).forces
            bound = friction.coefficient * float(now.normal_force.sum())
            if bound > 0.0:
                most = max(most, float(np.sqrt(np.square(rates).sum(axis=1)).sum()) / bound)
    return most


def changes_of_points(model: Model, last: SystemState, state: SystemState) -> float:
    """The largest change of what single points do in a step, over √mass: the forces on the nodes of
    a free slave, or of points that share one on the body they stand on."""
    system, most = model.mechanism, 0.0
    for name, mass in system.loose.items():
        change = change_of_nodes(model, name, last, state)
        most = max(most, math.sqrt(float((np.square(change).sum(axis=1) / mass).sum())))
    changes = np.zeros((len(system.free), 6))
    for part in model.contacts:
        before, now = last.contacts[part.name], state.contacts[part.name]
        if len(now.tangent):
            _add_felt(changes, system, part, _shared(before, now), state)
    return max([most, *(_over_mass(system, k, own, state) for k, own in enumerate(changes))])


def _shared(before: State, now: State) -> _Felt:
    """Changes of the normal forces of points that share one."""
    both = kept_of(before), kept_of(now)
    rows = np.union1d(*(kept.nonzero("normal_force")[0] for kept in both))
    forces = [
        kept.part("normal_force", rows)[:, None] * kept.part("normal_B", rows) for kept in both
    ]
    return _Felt(rows, turn_to_world(now.pose, forces[1] - forces[0]))


def unbalanced(model: Model, state: SystemState) -> float:
    """The largest force on a free body that nothing balances, over √mass, as `shaking_of`."""
    system = model.mechanism
    forces = state.rigid[:, FORCE : FORCE + 6]
    return max((_over_mass(system, k, force, state) for k, force in enumerate(forces)), default=0.0)


def _over_mass(system: Mechanism, k: int, rate: FloatArray, state: SystemState) -> float:
    """√(ṗᵀ M⁻¹ ṗ) of the rate (6,) of force and moment about the centre of a body."""
    one, turn = system.fixed[k], state.bodies.poses[int(system.free[k]), :3, :3]
    torque = product(turn.T, rate[3:] * one[SPINS : SPINS + 3])
    moment = product(one[AXES : AXES + 9].reshape(3, 3).T, torque)
    square = np.square(rate[:3] * one[WAYS : WAYS + 3]).sum() / one[MASS]
    return math.sqrt(float(square + (moment * moment / one[MOMENTS : MOMENTS + 3]).sum()))


def _rates(
    part: ContactPart, last: SystemState, state: SystemState, decay: float
) -> tuple[_Felt, _Felt]:
    """Rates of what a contact does to its slave: of its normal forces, and of friction."""
    before, now = last.contacts[part.name], state.contacts[part.name]
    return _elastic(before, now, state.step, decay), _gripped(before, now, state.step)


def _add_felt(
    rates: FloatArray, system: Mechanism, part: ContactPart, felt: _Felt, state: SystemState
) -> None:
    """Add what acts on the slave, and against it on the master, where these are free."""
    contact = state.contacts[part.name]
    places = to_world(contact.pose, contact.points_B[felt.rows])
    for side, sign in zip(system.sides(part.master, part.slave), (-1.0, 1.0), strict=True):
        if side is None or side not in system.row:
            continue
        k = system.row[side]
        add_forces(rates[k], places, sign * felt.forces, state.rigid[k, CENTRE : CENTRE + 3])


def _elastic(before: State, now: State, step: float, decay: float) -> _Felt:
    """Rates of the normal forces on the slave by stiffness alone: what sets in at once has none."""
    rows = np.flatnonzero(now.stiffness)
    normals, points = kept_of(now).part("normal_B", rows), now.points_B[rows]
    inward = -row_products(points - before.points_B[rows], normals) / step
    rate = now.stiffness[rows] * np.where(np.isfinite(inward), inward, 0.0)
    if len(now.damping):
        rate = rate + decay * now.damping[rows]
    return _Felt(rows, turn_to_world(now.pose, rate[:, None] * normals))


def _gripped(before: State, now: State, step: float) -> _Felt:
    """Rates of friction, of the points that carried before: what others have is their first."""
    kept, last = kept_of(now), kept_of(before)
    rows, traction = kept.listed("traction_B")
    if len(rows):
        carried = (kept.part("normal_force", rows) > 0.0) & (last.part("normal_force", rows) > 0.0)
        rows, traction = rows[carried], traction[carried]
    if len(rows) == 0:
        return _Felt(rows, np.zeros((0, 3)))
    rate = (traction - last.part("traction_B", rows)) / step
    return _Felt(rows, turn_to_world(now.pose, rate))


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
    for end, k in system.free_ends(system.springs[name]):
        for spring, sign, at in both:
            if spring.length == 0.0:
                continue
            axis = (spring.ends[1 - end] - spring.ends[end]) / spring.length
            size = sign * (spring.force - spring.damper) / state.step
            if sign > 0.0:
                size += decay * spring.damper
            place, force = spring.ends[end : end + 1], (size * axis)[None]
            add_forces(rates[k], place, force, at.rigid[k, CENTRE : CENTRE + 3])
