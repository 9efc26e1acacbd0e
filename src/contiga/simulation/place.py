"""Where bodies and slaves are at a time: what is prescribed, what is free, what is attached."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from contiga.contact.state import State
from contiga.dynamics.free import Attached, Free
from contiga.dynamics.prescribed import BodyMotion
from contiga.dynamics.rigid_bodies import Placed, drifted, started
from contiga.errors import InputError
from contiga.num.pose import as_pose
from contiga.num.rigid import to_world
from contiga.num.twist import Twist
from contiga.records import FloatArray
from contiga.simulation.load_forces import foresee_loads
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import Model, SlavePart
from contiga.simulation.system_state import BodyStates, SlaveState, SystemState

STILL = np.eye(4)


class Placement(NamedTuple):
    """Where all is, before the forces there are known: free velocities are foreseen."""

    bodies: BodyStates
    slaves: dict[str, SlaveState]
    free: Placed


def place(model: Model, last: SystemState | None, time: float) -> Placement:
    """Bodies and slaves at `time`, after the state `last`; None at the start."""
    system = model.mechanism
    if last is None:
        free = started(system.start, system.fixed)
    else:
        free = drifted(last.rigid, system.fixed, time - last.time)
        foresee_loads(model, last, free, time)
    n = len(system.index)
    poses, twists = np.zeros((n, 4, 4)), np.zeros((n, 6))
    poses[:] = STILL
    poses[system.free], twists[system.free] = free.poses, free.twists
    for name, motion, i in system.driven:
        poses[i], twists[i] = _driven(name, motion, time)
    if system.attached:
        poses, twists = poses[system.root], twists[system.root]
    bodies = BodyStates(system.index, poses, twists)
    slaves = {}
    for name, slave in model.slaves.items():
        if name in system.carried:
            slaves[name] = _carried(slave, bodies, system.carried[name])
        elif name in system.masses:
            slaves[name] = _drifted(model, last, name, time)
        else:
            slaves[name] = _slave_at(name, slave, time)
    return Placement(bodies, slaves, free)


def _driven(name: str, motion: BodyMotion, time: float) -> tuple[FloatArray, FloatArray]:
    """Pose and twist (6,) as a motion says; these are checked, since it may be a user's."""
    where = f"bodies[{name!r}]: motion at t = {time:g}"
    pose, twist = as_pose(motion.pose(time), where), motion.twist(time)
    if not isinstance(twist, Twist) or not all(
        np.shape(part) == (3,) and np.isfinite(part).all() for part in twist
    ):
        raise InputError(
            "twist(t) must be a velocity and a spin",
            where=where,
            found=twist,
            allowed="contiga.motion.Twist of two arrays (3,), finite",
        )
    return pose, np.concatenate(twist)


def _carried(part: SlavePart, bodies: BodyStates, host: int) -> SlaveState:
    """Points that are fixed to a body."""
    pose, twist = bodies.poses[host], bodies.twists[host]
    points = to_world(pose, part.slave.points)
    return SlaveState(points, Twist(twist[:3], twist[3:]).at(pose[:3, 3], points))


def _drifted(model: Model, last: SystemState | None, name: str, time: float) -> SlaveState:
    """Nodes that are free: half a kick, a drift, and the velocity that half a kick more gives."""
    part = model.slaves[name]
    if last is None:
        assert isinstance(part.motion, Free)
        points = part.slave.points
        return SlaveState(points.copy(), np.broadcast_to(part.motion.velocity, points.shape).copy())
    dt, (points, velocities) = time - last.time, last.slaves[name]
    kick = 0.5 * dt * nodal_acceleration(model, name, last.contacts)
    return SlaveState(points + dt * (velocities + kick), velocities + kick + kick)


def nodal_acceleration(model: Model, name: str, contacts: Mapping[str, State]) -> FloatArray:
    """(n, 3) of the free nodes of a slave, by its contacts and gravity."""
    force = nodal_force(model, name, contacts)
    return force / model.mechanism.masses[name][:, None] + model.gravity


def nodal_force(model: Model, name: str, contacts: Mapping[str, State]) -> FloatArray:
    """(n, 3) that the contacts do on the nodes of a slave."""
    own = [contacts[part.name].force for part in model.contacts if part.slave == name]
    if not own:
        return np.zeros(model.slaves[name].slave.points.shape)
    return np.asarray(sum(own[1:], own[0]))


def _slave_at(name: str, part: SlavePart, time: float) -> SlaveState:
    """A slave that follows what is prescribed."""
    assert not isinstance(part.motion, Free | Attached)
    state = SlaveState(part.motion.points(time), part.motion.velocities(time))
    for what, rows in zip(state._fields, state, strict=True):
        if np.shape(rows) != part.slave.points.shape:
            raise InputError(
                f"{what}(t) must have one row a slave point",
                where=f"slaves[{name!r}]: motion at t = {time:g}",
                found=np.shape(rows),
                allowed=str(part.slave.points.shape),
            )
    return state


def kicked_nodes(
    model: Model,
    last: SystemState | None,
    standing: Placement,
    contacts: Mapping[str, State],
    dt: float,
) -> dict[str, SlaveState]:
    """The slaves with the velocities that free nodes have at the end of the step."""
    slaves = dict(standing.slaves)
    for name in model.mechanism.masses:
        points, foreseen = slaves[name]
        if last is None:
            continue
        # What was foreseen lies as far beyond the middle of the step as the last ones before it.
        half = 0.5 * (last.slaves[name].velocities + foreseen)
        now = half + 0.5 * dt * nodal_acceleration(model, name, contacts)
        slaves[name] = SlaveState(points, now)
    return slaves


def frames(system: Mechanism, standing: Placement) -> BodyStates:
    """The bodies with the twists that free ones have once they are kicked."""
    twists = standing.bodies.twists.copy()
    twists[system.free] = standing.free.twists
    if system.attached:
        twists = twists[system.root]
    return BodyStates(system.index, standing.bodies.poses, twists)
