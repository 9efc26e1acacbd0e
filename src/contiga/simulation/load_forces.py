"""What loads do on bodies, and the velocities that they will give at the end of a step.

Loads are known beforehand, unlike the forces of what touches and pulls: dampers and friction, which
are asked with foreseen velocities, see those that the loads of then give.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import product
from contiga.dynamics.loads import Load
from contiga.dynamics.rigid_bodies import Placed, kicked
from contiga.records import FloatArray
from contiga.rigid.rigid_lanes import CENTRE, FORCE, TORQUE
from contiga.rigid.vectors import cross
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState


def point_of(pose: FloatArray, origin: FloatArray, at: FloatArray) -> FloatArray:
    """Where a point of a body is that was `at` (3,) when its frame stood at `origin` (4, 4)."""
    own = turned(origin[:3, :3].T, at - origin[:3, 3])
    return turned(pose[:3, :3], own) + pose[:3, 3]


def turned(R: FloatArray, v: FloatArray) -> FloatArray:
    """A vector (3,) turned by a rotation (3, 3)."""
    return np.asarray(R[:, 0] * v[0] + R[:, 1] * v[1] + R[:, 2] * v[2])


def loaded(
    load: Load, pose: FloatArray, origin: FloatArray, time: float
) -> tuple[FloatArray, FloatArray]:
    """Force and moment of a load on a body, whose frame stood at `origin` first; world axes."""
    force, moment = load.force_at(time), load.moment_at(time)
    if load.follow:
        R = product(pose[:3, :3], origin[:3, :3].T)
        force, moment = turned(R, force), turned(R, moment)
    return force, moment


def load_point(model: Model, load: Load, i: int, pose: FloatArray, rows: FloatArray) -> FloatArray:
    """Where a load acts: a point of the body `i` at `pose`, or its centre of mass, by the `rows`
    (b, 19) of free bodies."""
    system = model.mechanism
    if load.at is not None:
        return point_of(pose, model.origins[i], load.at)
    if i in system.row:
        return rows[system.row[i], CENTRE : CENTRE + 3]
    return pose[:3, 3]


def foresee_loads(model: Model, last: SystemState, free: Placed, time: float) -> None:
    """Change the twists of bodies that have drifted to those that the loads at `time` will give,
    with what else acted in `last`."""
    if not model.mechanism.loads:
        return
    change = np.zeros((len(free.rows), 6))
    for load in model.mechanism.loads:
        i = model.mechanism.root_of(load.body)
        k = model.mechanism.row.get(i)
        if k is not None:
            now = _about_centre(model, load, i, free.poses[k], free.rows, time)
            before = _about_centre(model, load, i, last.bodies.poses[i], last.rigid, last.time)
            change[k] += now - before
    if change.any():
        acting = free.rows[:, FORCE : TORQUE + 3] + change
        arms = free.rows[:, CENTRE : CENTRE + 3] - free.poses[:, :3, 3]
        acting[:, 3:] += cross(arms, acting[:, :3])
        ended = free._replace(rows=free.rows.copy())
        kicked(ended, model.mechanism.fixed, acting, time - last.time)


def _about_centre(
    model: Model, load: Load, i: int, pose: FloatArray, rows: FloatArray, time: float
) -> FloatArray:
    """(6,) force and moment about the centre of a free body."""
    force, moment = loaded(load, pose, model.origins[i], time)
    k = model.mechanism.row[i]
    arm = load_point(model, load, i, pose, rows) - rows[k, CENTRE : CENTRE + 3]
    return np.concatenate([force, moment + cross(arm, force)])
