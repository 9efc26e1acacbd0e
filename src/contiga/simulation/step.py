"""Take one step of a simulation: place what moves, then every contact, then apply their forces.

Work is integrated by the trapezoidal rule over each step, which suits a leapfrog: its kinetic
energy changes by exactly that work, up to a term in the square of the step that is recovered later.

`advance` is one step: `place`, `contact_states`, `acting_forces`, the kick of bodies and nodes by
these, and the energies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import NamedTuple

import numpy as np

from contiga.contact.loads import Column
from contiga.contact.state import State
from contiga.dynamics.belt_devices import Moment
from contiga.dynamics.nodes import Instant, ListedForces, NodeEnergies, SlaveState
from contiga.dynamics.rigid_bodies import (
    Placed,
    add_gravity,
    bodies_at_start,
    drift_bodies,
    kick_bodies,
    work_of_gravity,
)
from contiga.dynamics.slip_rings import SlipRingState
from contiga.dynamics.springs import SpringState
from contiga.errors import InputError
from contiga.jit import straight
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.frames import cross
from contiga.rigid.kernels.rigid_nb import add_wrench
from contiga.rigid.pose import as_pose, to_quaternion
from contiga.rigid.twist import Twist
from contiga.simulation.clock import Clock
from contiga.simulation.gas import ChamberState, covered_by
from contiga.simulation.joints import close_joints, joint_states, react_joints
from contiga.simulation.load_forces import add_loads, foresee_loads, work_of_loads
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import Model
from contiga.simulation.reasons import Choice
from contiga.simulation.springs import add_pulls, spring_states
from contiga.simulation.system_state import Acting, BodyStates, Energy, SystemState
from contiga.simulation.triggers import firing_times, trigger_states


class StepResult(NamedTuple):
    """The state after a step, and how the step was made."""

    state: SystemState
    wall_times: dict[str, float]
    """Wall-clock seconds of each contact, by name."""
    choice: Choice | None = None
    """Choice of an automatic step length; None for a given one."""


class Placement(NamedTuple):
    """Positions of all parts at the end of a step, with predicted velocities of free ones."""

    bodies: BodyStates
    slaves: dict[str, SlaveState]
    """By name; `advance` replaces them by those after the kick."""
    free: Placed
    """The free bodies; kicks change its arrays in place."""
    now: Instant
    """Time, length of the step, gravity, poses and twists of all bodies."""


class NodalForces(NamedTuple):
    """Forces of contacts, springs and gas on the nodes of one slave; see `Forces`."""

    model: Model
    name: str
    acting: Acting

    def __call__(self) -> FloatArray:
        """Return the forces (n, 3) on all nodes."""
        return nodal_force(*self)

    def on_dofs(self) -> FloatArray | None:
        """Return the forces (m, 3) on the control points of a master that the slave moves.

        They are summed over the contacts of that master; None if there are none.
        """
        forces = [
            self.acting.contacts[part.name].control_force
            for part in self.model.contacts
            if self.model.shapes.slave_of(part.master) == self.name
        ]
        return np.array(sum(forces[1:], forces[0])) if forces else None

    def listed(self) -> ListedForces:
        """Return forces (k, 3) on nodes with their rows, ascending; none acts on other nodes."""
        columns = []
        for part in self.model.contacts:
            if part.slave == self.name:
                columns.append(self.acting.contacts[part.name].kept.force)
        for end in self.model.mechanism.tied.get(self.name, ()):
            columns.append(Column(end.nodes, end.forces(self.acting.springs[end.spring].pull)))
        for name in self.model.chambers.of_slave.get(self.name, ()):
            columns.append(
                Column(self.model.chambers.skins[name].rows, self.acting.gas[name].force)
            )
        if len(columns) == 1:
            return ListedForces(*columns[0])
        count = len(self.model.slaves[self.name].slave.points)
        total = np.zeros((count, 3))
        for column in columns:
            column.add_to(total)
        if any(len(column.rows) == count for column in columns):
            return ListedForces(np.arange(count, dtype=np.int32), total)
        pushed = np.zeros(count, np.bool_)
        for column in columns:
            pushed[column.rows] = True
        rows = np.flatnonzero(pushed).astype(np.int32)
        return ListedForces(rows, total[rows])


def nodal_force(model: Model, name: str, acting: Acting) -> FloatArray:
    """Return the forces (n, 3) of contacts, springs and gas on the nodes of a slave."""
    contacts, springs, gas = acting.contacts, acting.springs, acting.gas
    tied = model.mechanism.tied.get(name, ())
    forces = [contacts[part.name].force for part in model.contacts if part.slave == name]
    if not forces:
        forces = [np.zeros(model.slaves[name].slave.points.shape)]
    total = np.array(sum(forces[1:], forces[0]))
    for end in tied:
        total[end.nodes] += end.forces(springs[end.spring].pull)
    for chamber in model.chambers.of_slave.get(name, ()):
        Column(model.chambers.skins[chamber].rows, gas[chamber].force).add_to(total)
    return total


def advance(
    model: Model,
    last: SystemState | None,
    time: float,
    clock: Clock,
    fired: Mapping[str, float] | None = None,
) -> StepResult:
    """Return the step from the state `last`, which is None at the start, to `time`.

    `fired` are the times at which triggers fire, by sensor; those of `last` if omitted. If another
    trigger fires within the step, the step is repeated with it, so that its devices act in the same
    step. A model that forces do not move, without sensors, has contacts alone: no wrenches, and no
    energies but theirs. The step is not judged, and `last` stays as it is.
    """
    if fired is None:
        fired = firing_times(last.triggers) if last is not None and model.triggered else {}
    begin = perf_counter()
    placement = place(model, last, time)
    clock.add("motion", begin)
    contacts, wall_times = contact_states(model, last, placement, clock)
    system, now = model.mechanism, placement.now
    bodies, slaves = placement.bodies, placement.slaves
    if not (system.has_dynamics or model.sensors):
        energy = contact_energy(contacts)
        return StepResult(SystemState(time, bodies, slaves, contacts, energy, now.dt), wall_times)
    begin = perf_counter()
    acting = acting_forces(model, last, placement, contacts, fired)
    if last is not None:
        for name in system.masses:
            forces = NodalForces(model, name, acting)
            slaves[name] = system.nodes[name].kick(last.slaves[name], slaves[name], forces, now)
    total = wrenches(model, acting, placement)
    kinetic = kick_bodies(placement.free, system.fixed, total[system.free], now.dt)
    if acting.joints is not None:
        kinetic, joints = react_joints(
            model, last, acting.joints, placement.free, bodies, time, total
        )
        acting = acting._replace(joints=joints)
    external, initial, peak = 0.0, None, 0.0
    if last is not None:
        external = last.energy.external + external_work(model, last, placement, acting, total)
        initial, peak = last.energy.initial, last.peak_energy
    of_slaves = [system.nodes[name].energy(slaves[name]) for name in system.masses]
    energy = energy_of(acting, of_slaves, kinetic, external, initial)
    # Twists of free bodies are now those after the kick, and what rides on bodies follows them.
    bodies = kicked_bodies(system, placement)
    now = now._replace(twists=bodies.twists)
    for name in system.carried_slaves:
        slaves[name] = system.nodes[name].with_carried_nodes(slaves[name], now)
    state = SystemState(
        time,
        bodies,
        slaves,
        contacts,
        energy,
        step=now.dt,
        rigid=placement.free.rows,
        wrenches=total,
        springs=acting.springs,
        gas=acting.gas,
        slip_rings=acting.rings,
        joints=acting.joints,
        rest=None if last is None else last.rest,
        peak_energy=max(peak, energy.total + energy.lost),
    )
    if model.triggered:
        triggers = trigger_states(model, last, state)
        new_times = {
            name: fires
            for name, fires in firing_times(triggers).items()
            if name not in fired and fires <= time
        }
        if new_times:
            return advance(model, last, time, clock, {**fired, **new_times})
        for name, fires in fired.items():
            triggers[name] = triggers[name]._replace(fires=fires)
        state = replace(state, triggers=triggers)
    clock.add("motion", begin)
    return StepResult(state, wall_times)


def contact_states(
    model: Model, last: SystemState | None, placement: Placement, clock: Clock
) -> tuple[dict[str, State], dict[str, float]]:
    """Return all contacts where their sides stand now, and the wall-clock seconds each took."""
    system, now = model.mechanism, placement.now
    contacts: dict[str, State] = {}
    wall_times: dict[str, float] = {}
    for part in model.contacts:
        begin = perf_counter()
        i, slave = system.index[part.master], placement.slaves[part.slave]
        points = model.shapes.points(part.master, now.time, placement.slaves)
        if last is None:
            state = part.contact.start(
                slave.points, now.poses[i], control_points=points, clock=clock
            )
        else:
            state = part.contact.step(
                last.contacts[part.name],
                slave.points,
                now.poses[i],
                now.dt,
                velocity=slave.velocities,
                twist=now.twists[i].reshape(2, 3),
                control_points=points,
                control_velocity=model.shapes.velocity(part.master, now.time, placement.slaves),
                clock=clock,
            )
        contacts[part.name] = state
        wall_times[part.name] = perf_counter() - begin
    return contacts, wall_times


def acting_forces(
    model: Model,
    last: SystemState | None,
    placement: Placement,
    contacts: dict[str, State],
    fired: Mapping[str, float],
) -> Acting:
    """Return the states of contacts, springs, gas, slip rings and joints where all parts stand now.

    `contacts` are returned as given; joints have no new reactions yet.
    """
    now, slaves = placement.now, placement.slaves
    springs: dict[str, SpringState] = {}
    rings: dict[str, SlipRingState] = {}
    if model.mechanism.springs:
        moment = Moment(now.time, now.dt, fired)
        springs, rings = spring_states(model, last, placement.bodies, slaves, moment)
    gas: dict[str, ChamberState] = {}
    if model.gas:

        def covered(slave: str) -> FloatArray:
            touching = [
                (part.contact, contacts[part.name])
                for part in model.contacts
                if part.slave == slave
            ]
            return covered_by(touching, model.slaves[slave].slave)

        last_gas = None if last is None else last.gas
        gas = model.chambers.states(last_gas, slaves, covered, now.time, now.dt, fired)
    joints = joint_states(model, last, placement.bodies) if model.joints else None
    return Acting(contacts, springs, gas, rings, joints)


def place(model: Model, last: SystemState | None, time: float) -> Placement:
    """Return bodies and slaves placed at `time` after the state `last`, which is None at the start.

    Velocities of free parts are predicted with the forces of `last` and the loads at `time`.

    Raises
    ------
    InputError
        A motion gives no rigid pose, or no finite twist.
    RunError
        A joint does not close.
    """
    system = model.mechanism
    dt = 0.0 if last is None else time - last.time
    if last is None:
        free = bodies_at_start(model.joint_fit.rows if model.joints else system.start, system.fixed)
    else:
        free = drift_bodies(last.rigid, system.fixed, dt)
    n = len(system.index)
    poses, twists = np.zeros((n, 4, 4)), np.zeros((n, 6))
    poses[:] = np.eye(4)
    for i, motion in system.driven.items():
        # Checked, since the motion may be a user's.
        where = f"bodies[{list(model.bodies)[i]!r}]: motion at t = {time:g}"
        poses[i], twist = as_pose(motion.pose(time), where), motion.twist(time)
        if not isinstance(twist, Twist) or not all(
            np.shape(part) == (3,) and np.isfinite(part).all() for part in twist
        ):
            raise InputError(
                "twist(t) must be a velocity and a spin",
                where=where,
                found=twist,
                allowed="contiga.motion.Twist of two arrays (3,), finite",
            )
        twists[i] = np.concatenate(twist)
    if last is not None:
        if model.joints:
            close_joints(model, last, free, poses, time)
        if system.loads:
            foresee_loads(model, last, free, time)
    poses[system.free], twists[system.free] = free.poses, free.twists
    if system.attached:
        poses, twists = poses[system.root], twists[system.root]
    now = Instant(time, dt, model.gravity, poses, twists)
    slaves: dict[str, SlaveState] = {}
    for name, nodes in system.nodes.items():
        if last is None:
            slaves[name] = nodes.start(now)
        else:
            acting = NodalForces(model, name, last.acting)
            slaves[name] = nodes.drift(last.slaves[name], acting, now)
    return Placement(BodyStates(system.index, poses, twists), slaves, free, now)


def kicked_bodies(system: Mechanism, placement: Placement) -> BodyStates:
    """Return the bodies with the twists that free ones have after the kick."""
    twists = placement.bodies.twists.copy()
    twists[system.free] = placement.free.twists
    if system.attached:
        twists = twists[system.root]
    return BodyStates(system.index, placement.bodies.poses, twists)


def wrenches(model: Model, acting: Acting, placement: Placement) -> FloatArray:
    """Return force and moment (n, 6) on each body about the origin of its frame, world axes.

    A body has the forces on the bodies attached to it, whose own rows are zero. Slaves must be
    at the end of the step, elements with their forces there. Reactions of joints are left out:
    `react_joints` adds them.
    """
    system, poses = model.mechanism, placement.bodies.poses
    total = np.zeros((len(system.index), 6))
    for part in model.contacts:
        state, sides = acting.contacts[part.name], model.mechanism.sides[part.name]
        i, host = sides.master, sides.slave
        straight(add_wrench)(state.wrench, sides.about, poses[i], total[i])
        if host is not None:
            rows, force = state.kept.force
            points = placement.slaves[part.slave].points[rows]
            add_forces(total[host], points, force, poses[host, :3, 3])
    for name, nodes in system.nodes.items():
        for host, points, force in nodes.forces_on_bodies(
            placement.slaves[name], NodalForces(model, name, acting)
        ):
            add_forces(total[host], points, force, poses[host, :3, 3])
    if acting.springs:
        add_pulls(system, acting.springs, poses, total)
    if acting.joints is not None:
        model.linkage.add_laws(acting.joints, poses, total)
    if system.loads:
        add_loads(model, poses, placement.free.rows, placement.now.time, total)
    if len(system.free) and model.gravity.any():
        add_gravity(placement.free, system.fixed, model.gravity, system.free, total)
    return total


def add_forces(
    wrench: FloatArray, points: FloatArray, forces: FloatArray, about: FloatArray
) -> None:
    """Add forces (k, 3) at points (k, 3) to a wrench (6,), in place, with moments about a point."""
    wrench[:3] += forces.sum(axis=0)
    wrench[3:] += cross(points - about, forces).sum(axis=0)


def contact_energy(contacts: Mapping[str, State]) -> Energy:
    """Return the energies of the contacts alone; the work on them counts as external."""
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
    acting: Acting,
    slaves: Sequence[NodeEnergies],
    kinetic: float,
    external: float,
    initial: float | None,
) -> Energy:
    """Return the energies of a system.

    `slaves` are the energies of nodes and elements, `kinetic` is the energy of bodies, `external`
    the work done on the system since the start, and `initial` the energy at the start; None at the
    start itself, when the total is.
    """
    of_contacts = contact_energy(acting.contacts)
    strain, hysteresis, damping = 0.0, of_contacts.hysteresis, of_contacts.damping
    for spring in acting.springs.values():
        strain += spring.stored
        hysteresis += spring.hysteresis
        damping += spring.damping
    friction = of_contacts.friction + sum(ring.friction for ring in acting.rings.values())
    if acting.joints is not None:
        for k in range(len(acting.joints.laws)):
            law = acting.joints.law(k)
            strain += law.stored
            hysteresis += law.hysteresis
            damping += law.damping
            friction += law.friction
    nodes = NodeEnergies(*map(sum, zip(*slaves, strict=True)))
    energy = Energy(
        of_contacts.contact,
        hysteresis + nodes.hysteresis,
        damping + nodes.damping,
        friction,
        kinetic + nodes.kinetic,
        strain + nodes.strain,
        external,
        0.0 if initial is None else initial,
        nodes.hourglass,
        nodes.viscosity,
        sum(chamber.gas.stored for chamber in acting.gas.values()),
    )
    return energy._replace(initial=energy.total) if initial is None else energy


def external_work(
    model: Model,
    last: SystemState,
    placement: Placement,
    acting: Acting,
    wrenches: FloatArray,
) -> float:
    """Return the work done on the system in a step, of forces by the trapezoidal rule.

    Gravity, loads, pretensioners and prescribed motions do work; the enthalpy of inflowing gas,
    less that of outflowing gas, is added. `wrenches` (n, 6) act at the end of the step.
    """
    system, slaves, work = model.mechanism, placement.slaves, 0.0
    if model.gravity.any():
        rows = placement.free.rows
        work += work_of_gravity(last.rigid, rows, system.fixed, model.gravity)
        for name in system.masses:
            nodes = system.nodes[name]
            work += nodes.gravity_work(last.slaves[name], slaves[name], model.gravity)
    if system.loads:
        poses, rows = placement.bodies.poses, placement.free.rows
        work += work_of_loads(model, last, poses, rows, placement.now)
    of_bodies = of_points = 0.0
    for i in system.driven:
        both = last.wrenches[i] + wrenches[i]
        if not both.any():
            continue
        X0, X1 = last.bodies.poses[i], placement.bodies.poses[i]
        turn = quaternion.rotation_vector(to_quaternion(X0), to_quaternion(X1))
        of_bodies -= 0.5 * float((both[:3] * (X1[:3, 3] - X0[:3, 3])).sum())
        of_bodies -= 0.5 * float((both[3:] * turn).sum())
    for part in model.contacts:
        if model.shapes.is_prescribed(part.master):
            old, new = last.contacts[part.name], acting.contacts[part.name]
            both = old.control_force + new.control_force
            of_bodies -= 0.5 * float((both * (new.control_points - old.control_points)).sum())
    for name, nodes in system.nodes.items():
        if nodes.host is None:  # else their forces act on the host
            before, after = (NodalForces(model, name, each) for each in (last.acting, acting))
            of_points += nodes.motion_work(last.slaves[name], slaves[name], before, after)
    for name, spring in acting.springs.items():
        work += spring.devices.work - last.springs[name].devices.work
    if model.gas:
        work += model.chambers.came(last.gas, acting.gas)
    return work + of_bodies + of_points
