"""Where the energy of a system is, and what came in from outside, step by step.

Work is counted by the trapezoidal rule over each step, which is what a leapfrog does: its kinetic
energy changes by just that, up to a term in the square of the step that comes back. That of loads,
which are told over time and may come and go within few steps, has no such term.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from contiga.contact.state import State
from contiga.dynamics.nodes import Stored
from contiga.dynamics.rigid_bodies import work_of_gravity
from contiga.dynamics.springs import SpringState
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.pose import to_quaternion
from contiga.rigid.rigid_lanes import CENTRE, VELOCITY
from contiga.simulation.load_forces import load_point, loaded
from contiga.simulation.model import Model
from contiga.simulation.place import Placement, forces_on
from contiga.simulation.system_state import Energy, SystemState


def contact_energy(contacts: Mapping[str, State]) -> Energy:
    """Of the contacts alone: what moves them does their work."""
    stored = hysteresis = damping = friction = work = 0.0
    for state in contacts.values():
        energy = state.energy
        stored += energy.stored
        hysteresis += energy.hysteresis
        damping += energy.damping
        friction += energy.friction
        work += energy.work
    return Energy(stored, hysteresis, damping, friction, external=work)


def energy_of(
    contacts: Mapping[str, State],
    springs: Mapping[str, SpringState],
    slaves: Sequence[Stored],
    kinetic: float,
    external: float,
    initial: float | None,
) -> Energy:
    """Of a system: `kinetic` of its bodies, `external` work since the start and the `initial`
    energy, which is None at the start."""
    of_contacts = contact_energy(contacts)
    strain, hysteresis, damping = 0.0, of_contacts.hysteresis, of_contacts.damping
    for spring in springs.values():
        strain += spring.stored
        hysteresis += spring.hysteresis
        damping += spring.damping
    nodes = Stored(*map(sum, zip(*slaves, strict=True)))
    energy = Energy(
        of_contacts.contact,
        hysteresis + nodes.hysteresis,
        damping + nodes.damping,
        of_contacts.friction,
        kinetic + nodes.kinetic,
        strain + nodes.strain,
        external,
        0.0 if initial is None else initial,
        nodes.hourglass,
        nodes.viscosity,
    )
    return energy._replace(initial=energy.total) if initial is None else energy


def external_work(
    model: Model,
    last: SystemState,
    standing: Placement,
    contacts: Mapping[str, State],
    wrenches: FloatArray,
    time: float,
) -> float:
    """Work done from outside in a step: by gravity, loads and what moves prescribed bodies."""
    return (
        _by_gravity(model, last, standing)
        + _by_loads(model, last, standing, time)
        + _by_bodies(model, last, standing, wrenches)
        + _by_points(model, last, standing, contacts)
    )


def _by_gravity(model: Model, last: SystemState, standing: Placement) -> float:
    system = model.mechanism
    work = work_of_gravity(last.rigid, standing.free.rows, system.fixed, model.gravity)
    for name, nodes in system.nodes.items():
        work += nodes.by_gravity(last.slaves[name], standing.slaves[name], model.gravity)
    return work


def _by_loads(model: Model, last: SystemState, standing: Placement, time: float) -> float:
    """Loads on free bodies; on others what moves them takes it back."""
    system, work = model.mechanism, 0.0
    if not system.loads:
        return work
    for load in system.loads:
        i = int(system.root[system.index[load.body]])
        if i not in system.row:
            continue
        poses = last.bodies.poses[i], standing.bodies.poses[i]
        force, moment = zip(
            loaded(load, poses[0], model.origins[i], last.time),
            loaded(load, poses[1], model.origins[i], time),
            strict=True,
        )
        way = load_point(model, load, i, poses[1], standing.free.rows)
        way = way - load_point(model, load, i, poses[0], last.rigid)
        work += 0.5 * float(((force[0] + force[1]) * way).sum())
        if moment[0].any() or moment[1].any():
            work += 0.5 * float(((moment[0] + moment[1]) * _turn(*poses)).sum())
    return work + load_work_beyond_way(model, last, standing.free.rows, standing.bodies.poses, time)


def load_work_beyond_way(
    model: Model, last: SystemState, rows: FloatArray, poses: FloatArray, time: float
) -> float:
    """What loads do on the centres of free bodies by their mean velocity in a step to `time`, more
    than along the way.

    The kinetic energy changes by just the mean force times the mean velocity. Along the way a force
    that sets in within the step does hardly any work yet: it comes with the next steps, as it ends.
    """
    system, work = model.mechanism, 0.0
    for load in system.loads:
        i = int(system.root[system.index[load.body]])
        if i not in system.row:
            continue
        a, b = last.rigid[system.row[i]], rows[system.row[i]]
        before, _ = loaded(load, last.bodies.poses[i], model.origins[i], last.time)
        now, _ = loaded(load, poses[i], model.origins[i], time)
        mean = 0.5 * (a[VELOCITY : VELOCITY + 3] + b[VELOCITY : VELOCITY + 3])
        way = b[CENTRE : CENTRE + 3] - a[CENTRE : CENTRE + 3]
        work += 0.5 * float(((before + now) * ((time - last.time) * mean - way)).sum())
    return work


def _by_bodies(model: Model, last: SystemState, standing: Placement, wrenches: FloatArray) -> float:
    """By what moves prescribed bodies, against the forces on them."""
    work = 0.0
    for i in model.mechanism.driven:
        both = last.wrenches[i] + wrenches[i]
        if not both.any():
            continue
        X0, X1 = last.bodies.poses[i], standing.bodies.poses[i]
        work -= 0.5 * float((both[:3] * (X1[:3, 3] - X0[:3, 3])).sum())
        work -= 0.5 * float((both[3:] * _turn(X0, X1)).sum())
    return work


def _by_points(
    model: Model, last: SystemState, standing: Placement, contacts: Mapping[str, State]
) -> float:
    """By what moves prescribed points, against the forces on them."""
    work = 0.0
    for name, nodes in model.mechanism.nodes.items():
        forces = [forces_on(model, name, at) for at in (last.contacts, contacts)]
        work += nodes.by_motion(last.slaves[name], standing.slaves[name], *forces)
    return work


def _turn(X0: FloatArray, X1: FloatArray) -> FloatArray:
    """(3,) rotation vector from one pose to another."""
    return quaternion.rotation_vector(to_quaternion(X0), to_quaternion(X1))
