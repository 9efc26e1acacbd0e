"""Where bodies and slaves are at a time: what is prescribed, what is free, what is attached."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from contiga.contact.loads import NO_ROWS
from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.dynamics.nodes import Forces, Instant, Pushes, SlaveState
from contiga.dynamics.prescribed import BodyMotion
from contiga.dynamics.rigid_bodies import Placed, drifted, started
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.pose import as_pose
from contiga.rigid.twist import Twist
from contiga.simulation.load_forces import foresee_loads
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import Model
from contiga.simulation.system_state import BodyStates, SystemState

STILL = np.eye(4)


class Placement(NamedTuple):
    """Where all is, before the forces there are known: free velocities are foreseen."""

    bodies: BodyStates
    slaves: dict[str, SlaveState]
    free: Placed
    now: Instant


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
    for i, motion in system.driven.items():
        poses[i], twists[i] = _driven(list(model.bodies)[i], motion, time)
    if system.attached:
        poses, twists = poses[system.root], twists[system.root]
    now = Instant(time, 0.0 if last is None else time - last.time, model.gravity, poses, twists)
    slaves = {
        name: nodes.start(now)
        if last is None
        else nodes.drift(last.slaves[name], forces_on(model, name, last.contacts), now)
        for name, nodes in system.nodes.items()
    }
    return Placement(BodyStates(system.index, poses, twists), slaves, free, now)


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


class ForcesOn(NamedTuple):
    """What the contacts do on the nodes of a slave; see `Forces`."""

    model: Model
    name: str
    contacts: Mapping[str, State]

    def __call__(self) -> FloatArray:
        """(n, 3) of all nodes."""
        return nodal_force(*self)

    def listed(self) -> Pushes:
        """Of those they act on."""
        columns = [
            kept_of(self.contacts[part.name]).listed("force")
            for part in self.model.contacts
            if part.slave == self.name
        ]
        if len(columns) == 1:
            return Pushes(*columns[0])
        rows, place = np.unique(
            np.concatenate([NO_ROWS, *(column.rows for column in columns)]), return_inverse=True
        )
        forces = np.zeros((len(rows), 3))
        first = 0
        for column in columns:  # in each a node stands once
            forces[place[first : first + len(column.rows)]] += column.values
            first += len(column.rows)
        return Pushes(rows, forces)


def forces_on(model: Model, name: str, contacts: Mapping[str, State]) -> Forces:
    """What the contacts do on the nodes of a slave, summed once it is asked for."""
    return ForcesOn(model, name, contacts)


def nodal_force(model: Model, name: str, contacts: Mapping[str, State]) -> FloatArray:
    """(n, 3) that the contacts do on the nodes of a slave."""
    forces = [contacts[part.name].force for part in model.contacts if part.slave == name]
    if not forces:
        return np.zeros(model.slaves[name].slave.points.shape)
    return np.asarray(sum(forces[1:], forces[0]))


def change_of_nodes(model: Model, name: str, last: SystemState, state: SystemState) -> FloatArray:
    """(n, 3) by which that changes from one state to another."""
    return nodal_force(model, name, last.contacts) - nodal_force(model, name, state.contacts)


def kicked_nodes(
    model: Model, last: SystemState, standing: Placement, contacts: Mapping[str, State]
) -> dict[str, SlaveState]:
    """The slaves as they are at the end of the step, by the forces there."""
    return {
        name: nodes.kick(
            last.slaves[name],
            standing.slaves[name],
            forces_on(model, name, contacts),
            standing.now,
        )
        for name, nodes in model.mechanism.nodes.items()
    }


def frames(system: Mechanism, standing: Placement) -> BodyStates:
    """The bodies with the twists that free ones have once they are kicked."""
    twists = standing.bodies.twists.copy()
    twists[system.free] = standing.free.twists
    if system.attached:
        twists = twists[system.root]
    return BodyStates(system.index, standing.bodies.poses, twists)
