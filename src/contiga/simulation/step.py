"""Take one step of a simulation: place what moves, then every contact, then apply their forces.

Work is counted by the trapezoidal rule over each step, which is what a leapfrog does: its kinetic
energy changes by just that, up to a term in the square of the step that comes back.
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
from contiga.dynamics.linkage import JointStates
from contiga.dynamics.nodes import Instant, Pushes, SlaveState, Stored
from contiga.dynamics.rigid_bodies import (
    Placed,
    add_gravity,
    drifted,
    kicked,
    started,
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


class Stepped(NamedTuple):
    """The outcome of a step."""

    state: SystemState
    walls: dict[str, float]
    """Seconds each contact took, by contact."""
    choice: Choice | None = None
    """How its length was chosen; None where it was given."""


class Placement(NamedTuple):
    """Positions of all parts before the forces there are known: free velocities are foreseen."""

    bodies: BodyStates
    slaves: dict[str, SlaveState]
    free: Placed
    now: Instant


class ForcesOn(NamedTuple):
    """Forces of contacts, springs and gas on a slave's nodes: see `Forces`."""

    model: Model
    name: str
    acting: Acting

    def __call__(self) -> FloatArray:
        """Return the forces (n, 3) on all nodes."""
        return nodal_force(*self)

    def on_degrees(self) -> FloatArray | None:
        """Return the forces (m, 3) on the degrees of freedom of a slave that is a master, too."""
        forces = [
            self.acting.contacts[part.name].control_force
            for part in self.model.contacts
            if self.model.shapes.slave_of(part.master) == self.name
        ]
        return np.array(sum(forces[1:], forces[0])) if forces else None

    def listed(self) -> Pushes:
        """Return the forces on those nodes that any act on."""
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
            return Pushes(*columns[0])
        count = len(self.model.slaves[self.name].slave.points)
        total = np.zeros((count, 3))
        for column in columns:
            column.add_to(total)
        if any(len(column.rows) == count for column in columns):
            return Pushes(np.arange(count, dtype=np.int32), total)
        pushed = np.zeros(count, np.bool_)
        for column in columns:
            pushed[column.rows] = True
        rows = np.flatnonzero(pushed).astype(np.int32)
        return Pushes(rows, total[rows])


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
) -> Stepped:
    """Return the simulation at `time`, advanced from the state `last`; None at the start.

    `fired` are the times at which triggers fire, by sensor; those known in `last` if omitted. If
    another trigger fires within the step, the step is repeated with it, so that its devices act in
    the same step.
    """
    if fired is None:
        fired = {} if last is None else firing_times(last.triggers)
    begun = perf_counter()
    standing = place(model, last, time)
    clock.add("motion", begun)
    system, now = model.mechanism, standing.now
    contacts: dict[str, State] = {}
    walls: dict[str, float] = {}
    for part in model.contacts:
        begun = perf_counter()
        i, slave = system.index[part.master], standing.slaves[part.slave]
        points = model.shapes.points(part.master, time, standing.slaves)
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
                control_velocity=model.shapes.velocity(part.master, time, standing.slaves),
                clock=clock,
            )
        contacts[part.name] = state
        walls[part.name] = perf_counter() - begun
    if not (system.moved or model.sensors):
        energy = contact_energy(contacts)
        bodies, slaves = standing.bodies, standing.slaves
        return Stepped(SystemState(time, bodies, slaves, contacts, energy, now.dt), walls)
    begun = perf_counter()
    system, now = model.mechanism, standing.now
    moment = Moment(now.time, now.dt, fired)
    springs: dict[str, SpringState] = {}
    rings: dict[str, SlipRingState] = {}
    if system.springs:
        springs, rings = spring_states(model, last, standing.bodies, standing.slaves, moment)
    gas: dict[str, ChamberState] = {}
    if model.gas:

        def covered(slave: str) -> FloatArray:
            touching = [
                (part.contact, contacts[part.name])
                for part in model.contacts
                if part.slave == slave
            ]
            return covered_by(touching, model.slaves[slave].slave)

        filled = None if last is None else last.gas
        gas = model.chambers.states(
            filled, standing.slaves, covered, now.time, now.dt, moment.fired
        )
    joints: JointStates | None = None
    if model.joints:
        joints = joint_states(model, last, standing.bodies)
    acting = Acting(contacts, springs, gas, rings, joints)
    if last is not None:
        for name in system.masses:
            before, there = last.slaves[name], standing.slaves[name]
            forces = ForcesOn(model, name, acting)
            standing.slaves[name] = system.nodes[name].kick(before, there, forces, now)
    total = wrenches(model, acting, standing)
    kinetic = kicked(standing.free, system.fixed, total[system.free], now.dt)
    if joints is not None:
        kinetic, joints = react_joints(
            model, last, joints, standing.free, standing.bodies, now.time, total
        )
        acting = acting._replace(joints=joints)
    external, initial, peak = 0.0, None, 0.0
    if last is not None:
        external = last.energy.external
        external += external_work(model, last, standing, acting, total)
        initial, peak = last.energy.initial, last.peak_energy
    inside = []
    for name in system.masses:
        inside.append(system.nodes[name].energy(standing.slaves[name]))
    energy = energy_of(acting, inside, kinetic, external, initial)
    bodies = frames(system, standing)
    now = now._replace(twists=bodies.twists)
    for name in system.riding:
        standing.slaves[name] = system.nodes[name].carried(standing.slaves[name], now)
    moved = SystemState(
        now.time,
        bodies,
        standing.slaves,
        contacts,
        energy,
        step=now.dt,
        rigid=standing.free.rows,
        wrenches=total,
        springs=springs,
        gas=gas,
        slip_rings=rings,
        joints=joints,
        rest=None if last is None else last.rest,
        peak_energy=max(peak, energy.total + energy.lost),
    )
    if model.triggered:
        triggers = trigger_states(model, last, moved)
        within = {
            name: fires
            for name, fires in firing_times(triggers).items()
            if name not in fired and fires <= time
        }
        if within:
            return advance(model, last, time, clock, {**fired, **within})
        for name, fires in fired.items():
            triggers[name] = triggers[name]._replace(fires=fires)
        moved = replace(moved, triggers=triggers)
    clock.add("motion", begun)
    return Stepped(moved, walls)


def place(model: Model, last: SystemState | None, time: float) -> Placement:
    """Place bodies and slaves at `time`, after the state `last`; None at the start."""
    system = model.mechanism
    dt = 0.0 if last is None else time - last.time
    if last is None:
        free = started(model.joint_fit.rows if model.joints else system.start, system.fixed)
    else:
        free = drifted(last.rigid, system.fixed, dt)
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
            acting = ForcesOn(model, name, last.acting)
            slaves[name] = nodes.drift(last.slaves[name], acting, now)
    return Placement(BodyStates(system.index, poses, twists), slaves, free, now)


def frames(system: Mechanism, standing: Placement) -> BodyStates:
    """Return the bodies with the twists that free ones have once they are kicked."""
    twists = standing.bodies.twists.copy()
    twists[system.free] = standing.free.twists
    if system.attached:
        twists = twists[system.root]
    return BodyStates(system.index, standing.bodies.poses, twists)


def wrenches(
    model: Model,
    acting: Acting,
    standing: Placement,
) -> FloatArray:
    """Return force and moment (n, 6) on each body about the origin of its frame, world axes.

    Of a body that others are attached to, with those on these; zero of what is attached. Slaves
    are to be at the end of the step, elements with their forces there.
    """
    system, poses = model.mechanism, standing.bodies.poses
    total = np.zeros((len(system.index), 6))
    for part in model.contacts:
        state, sides = acting.contacts[part.name], model.mechanism.sides[part.name]
        i, host = sides.master, sides.slave
        straight(add_wrench)(state.wrench, sides.about, poses[i], total[i])
        if host is not None:
            rows, force = state.kept.force
            points = standing.slaves[part.slave].points[rows]
            add_forces(total[host], points, force, poses[host, :3, 3])
    for name, nodes in system.nodes.items():
        for host, points, force in nodes.pulls(
            standing.slaves[name], ForcesOn(model, name, acting)
        ):
            add_forces(total[host], points, force, poses[host, :3, 3])
    if acting.springs:
        add_pulls(system, acting.springs, poses, total)
    if acting.joints is not None:
        model.linkage.add_laws(acting.joints, poses, total)
    if system.loads:
        add_loads(model, poses, standing.free.rows, standing.now.time, total)
    if len(system.free) and model.gravity.any():
        add_gravity(standing.free, system.fixed, model.gravity, system.free, total)
    return total


def add_forces(
    wrench: FloatArray, points: FloatArray, forces: FloatArray, about: FloatArray
) -> None:
    """Add forces (k, 3) at points (k, 3) to a wrench, with their moments about a point."""
    wrench[:3] += forces.sum(axis=0)
    wrench[3:] += cross(points - about, forces).sum(axis=0)


def contact_energy(contacts: Mapping[str, State]) -> Energy:
    """Return the energies of the contacts alone: what moves them does their work."""
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
    slaves: Sequence[Stored],
    kinetic: float,
    external: float,
    initial: float | None,
) -> Energy:
    """Return the energies of a system.

    `kinetic` is that of its bodies, `external` the work since the start, `initial` the energy then,
    None at the start itself.
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
    nodes = Stored(*map(sum, zip(*slaves, strict=True)))
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
    standing: Placement,
    acting: Acting,
    wrenches: FloatArray,
) -> float:
    """Return the work done from outside in a step.

    Gravity, loads, pretensioners and what moves prescribed bodies and points do it, and the
    enthalpy of gas that comes and goes counts.
    """
    system, slaves, work = model.mechanism, standing.slaves, 0.0
    if model.gravity.any():
        rows = standing.free.rows
        work += work_of_gravity(last.rigid, rows, system.fixed, model.gravity)
        for name in system.masses:
            nodes = system.nodes[name]
            work += nodes.by_gravity(last.slaves[name], slaves[name], model.gravity)
    if system.loads:
        work += work_of_loads(model, last, standing.bodies.poses, standing.free.rows, standing.now)
    of_bodies = of_points = 0.0
    for i in system.driven:
        both = last.wrenches[i] + wrenches[i]
        if not both.any():
            continue
        X0, X1 = last.bodies.poses[i], standing.bodies.poses[i]
        turn = quaternion.rotation_vector(to_quaternion(X0), to_quaternion(X1))
        of_bodies -= 0.5 * float((both[:3] * (X1[:3, 3] - X0[:3, 3])).sum())
        of_bodies -= 0.5 * float((both[3:] * turn).sum())
    for part in model.contacts:
        if model.shapes.is_told(part.master):
            was, now = last.contacts[part.name], acting.contacts[part.name]
            both = was.control_force + now.control_force
            of_bodies -= 0.5 * float((both * (now.control_points - was.control_points)).sum())
    for name, nodes in system.nodes.items():
        if nodes.host is None:  # else the body has their forces
            before, after = (ForcesOn(model, name, each) for each in (last.acting, acting))
            of_points += nodes.by_motion(last.slaves[name], slaves[name], before, after)
    for name, spring in acting.springs.items():
        work += spring.devices.work - last.springs[name].devices.work
    if model.gas:
        work += model.chambers.came(last.gas, acting.gas)
    return work + of_bodies + of_points
