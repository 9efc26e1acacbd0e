"""Forces on bodies: what contacts, springs, loads and weight do, summed for each body."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from contiga.contact.state import State
from contiga.contact.state_rows import kept_of
from contiga.dynamics.rigid_bodies import add_gravity
from contiga.dynamics.springs import SpringState
from contiga.records import FloatArray
from contiga.rigid.kernels.rigid_nb import add_wrench
from contiga.rigid.vectors import cross
from contiga.simulation.load_forces import load_point, loaded, point_of
from contiga.simulation.model import Model
from contiga.simulation.place import Placement, forces_on
from contiga.simulation.system_state import SystemState


def spring_states(
    model: Model, last: SystemState | None, standing: Placement
) -> dict[str, SpringState]:
    """All springs where their ends are now."""
    states = {}
    for name, spring in model.mechanism.springs.items():
        ends, velocities = np.empty((2, 3)), np.zeros((2, 3))
        for k, body in enumerate(spring.between):
            ends[k] = spring.at[k]
            i = model.mechanism.number(body)
            if i is not None:
                pose, twist = standing.bodies.poses[i], standing.bodies.twists[i]
                ends[k] = point_of(pose, model.origins[i], spring.at[k])
                velocities[k] = twist[:3] + cross(twist[3:], ends[k] - pose[:3, 3])
        if last is None:
            states[name] = spring.start(ends, velocities)
        else:
            states[name] = spring.step(last.springs[name], ends, velocities)
    return states


def wrenches(
    model: Model,
    contacts: Mapping[str, State],
    springs: Mapping[str, SpringState],
    standing: Placement,
    time: float,
) -> FloatArray:
    """(n, 6) force and moment on each body about the origin of its frame, world axes.

    Of a body that others are attached to, with those on these; zero of what is attached. Slaves
    are to be at the end of the step, elements with their forces there.
    """
    system, poses = model.mechanism, standing.bodies.poses
    total = np.zeros((len(system.index), 6))
    for part in model.contacts:
        state, i = contacts[part.name], system.root_of(part.master)
        about = model.bodies[part.master].body.reference_point
        add_wrench(state.wrench, about, poses[i], total[i])
        host = system.carried.get(part.slave)
        if host is not None:
            rows, force = kept_of(state).listed("force")
            points = standing.slaves[part.slave].points[rows]
            add_forces(total[host], points, force, poses[host, :3, 3])
    for name, nodes in system.nodes.items():
        for joint in nodes.joints:
            slave = standing.slaves[name]
            force = nodes.acting(slave, forces_on(model, name, contacts))[joint.rows]
            points = slave.points[joint.rows]
            add_forces(total[joint.host], points, force, poses[joint.host, :3, 3])
    for name, spring in springs.items():
        pull = spring.pull
        for k, body in enumerate(system.springs[name].between):
            end = system.number(body)
            if end is not None:
                sign = 1.0 if k == 0 else -1.0
                _add(total[end], sign * pull, spring.ends[k] - poses[end, :3, 3])
    for load in system.loads:
        i = system.root_of(load.body)
        force, moment = loaded(load, poses[i], model.origins[i], time)
        _add(
            total[i],
            force,
            load_point(model, load, i, poses[i], standing.free.rows) - poses[i, :3, 3],
            moment,
        )
    add_gravity(standing.free, system.fixed, model.gravity, system.free, total)
    return total


def add_forces(
    wrench: FloatArray, points: FloatArray, forces: FloatArray, about: FloatArray
) -> None:
    """Add forces (k, 3) at points (k, 3) to a wrench, with their moments about a point."""
    wrench[:3] += forces.sum(axis=0)
    wrench[3:] += cross(points - about, forces).sum(axis=0)


def _add(
    wrench: FloatArray, force: FloatArray, arm: FloatArray, moment: FloatArray | None = None
) -> None:
    """Add a force that acts at `arm` from the origin, and a moment."""
    wrench[:3] += force
    wrench[3:] += cross(arm, force)
    if moment is not None:
        wrench[3:] += moment
