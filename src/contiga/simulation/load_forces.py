"""Apply loads to bodies, and predict the velocities that they cause by the end of a step.

Loads are known in advance, unlike the forces of contacts and springs. Dampers and friction are
evaluated at predicted velocities, which include the loads at the end of the step. Loads may act for
a few steps only, so that the error of their work by the trapezoidal rule is not recovered later.
"""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import product
from contiga.dynamics.loads import Load
from contiga.dynamics.nodes import Instant
from contiga.dynamics.rigid_bodies import Placed, kick_bodies
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid.frames import cross
from contiga.rigid.pose import to_quaternion
from contiga.rigid.rigid_lanes import CENTRE, FORCE, TORQUE, VELOCITY
from contiga.simulation.model import Model
from contiga.simulation.system_state import SystemState


def point_of(pose: FloatArray, origin: FloatArray, at: FloatArray) -> FloatArray:
    """Return the position of a point of a body that was `at` (3,) with its frame at `origin`."""
    in_body = rotated(origin[:3, :3].T, at - origin[:3, 3])
    return rotated(pose[:3, :3], in_body) + pose[:3, 3]


def rotated(R: FloatArray, v: FloatArray) -> FloatArray:
    """Return a vector (3,) rotated by a matrix (3, 3)."""
    return np.asarray(R[:, 0] * v[0] + R[:, 1] * v[1] + R[:, 2] * v[2])


def load_on_body(
    load: Load, pose: FloatArray, origin: FloatArray, time: float
) -> tuple[FloatArray, FloatArray]:
    """Return force and moment (3,) of a load on a body that started at `origin`; world axes.

    A load that follows its body turns with it.
    """
    force, moment = load.force_at(time), load.moment_at(time)
    if load.follow:
        R = product(pose[:3, :3], origin[:3, :3].T)
        force, moment = rotated(R, force), rotated(R, moment)
    return force, moment


def load_point(model: Model, load: Load, i: int, pose: FloatArray, rows: FloatArray) -> FloatArray:
    """Return the point (3,) where a load acts on body `i` at `pose`, world axes.

    If the load has no point it is the centre of mass of a free body, from their `rows` (b, 19), and
    the origin of the frame of any other.
    """
    system = model.mechanism
    if load.at is not None:
        return point_of(pose, model.origins[i], load.at)
    if i in system.row:
        return rows[system.row[i], CENTRE : CENTRE + 3]
    return pose[:3, 3]


def add_loads(
    model: Model, poses: FloatArray, rows: FloatArray, time: float, total: FloatArray
) -> None:
    """Add all loads to the wrenches `total` (n, 6) on bodies at `poses` (n, 4, 4), in place.

    Wrenches are about the origins of frames; loads on attached bodies act on their root. `rows`
    (b, 19) are the states of free bodies.
    """
    for load in model.mechanism.loads:
        i = model.mechanism.root_of(load.body)
        force, moment = load_on_body(load, poses[i], model.origins[i], time)
        arm = load_point(model, load, i, poses[i], rows) - poses[i, :3, 3]
        total[i, :3] += force
        total[i, 3:] += cross(arm, force)
        total[i, 3:] += moment


def foresee_loads(model: Model, last: SystemState, free: Placed, time: float) -> None:
    """Change the twists of drifted bodies, in place, to those that the loads at `time` will cause.

    All other forces stay as in `last`, and so do the rows of `free`. Nothing changes if the loads
    are those of `last`.
    """
    change = np.zeros((len(free.rows), 6))
    for load in model.mechanism.loads:
        i = model.mechanism.root_of(load.body)
        k = model.mechanism.row.get(i)
        if k is not None:
            now = _load_about_centre(model, load, i, free.poses[k], free.rows, time)
            before = _load_about_centre(model, load, i, last.bodies.poses[i], last.rigid, last.time)
            change[k] += now - before
    if change.any():
        acting = free.rows[:, FORCE : TORQUE + 3] + change
        arms = free.rows[:, CENTRE : CENTRE + 3] - free.poses[:, :3, 3]
        acting[:, 3:] += cross(arms, acting[:, :3])
        ended = free._replace(rows=free.rows.copy())
        kick_bodies(ended, model.mechanism.fixed, acting, time - last.time)


def _load_about_centre(
    model: Model, load: Load, i: int, pose: FloatArray, rows: FloatArray, time: float
) -> FloatArray:
    """Return force and moment (6,) of a load about the centre of mass of the free body `i`."""
    force, moment = load_on_body(load, pose, model.origins[i], time)
    k = model.mechanism.row[i]
    arm = load_point(model, load, i, pose, rows) - rows[k, CENTRE : CENTRE + 3]
    return np.concatenate([force, moment + cross(arm, force)])


def work_of_loads(
    model: Model, last: SystemState, poses: FloatArray, rows: FloatArray, now: Instant
) -> float:
    """Return the work of loads on free bodies in a step, by the trapezoidal rule along the path.

    `unrealised_load_work` is added, which balances it with the kinetic energy. On other bodies the
    prescribed motion takes the work back.
    """
    system, work = model.mechanism, 0.0
    for load in system.loads:
        i = system.root_of(load.body)
        if i not in system.row:
            continue
        X0, X1 = last.bodies.poses[i], poses[i]
        force0, moment0 = load_on_body(load, X0, model.origins[i], last.time)
        force1, moment1 = load_on_body(load, X1, model.origins[i], now.time)
        path = load_point(model, load, i, X1, rows)
        path = path - load_point(model, load, i, X0, last.rigid)
        work += 0.5 * float(((force0 + force1) * path).sum())
        if moment0.any() or moment1.any():
            turn = quaternion.rotation_vector(to_quaternion(X0), to_quaternion(X1))
            work += 0.5 * float(((moment0 + moment1) * turn).sum())
    return work + unrealised_load_work(model, last, rows, poses, now.time)


def unrealised_load_work(
    model: Model, last: SystemState, rows: FloatArray, poses: FloatArray, time: float
) -> float:
    """Return the work of loads by the mean velocity of centres in a step, less that along the path.

    The kinetic energy changes by the mean force times the mean velocity. A force that sets in
    within the step does hardly any work along the path yet: it does so later, until it ends.
    Moments do not count.
    """
    system, work = model.mechanism, 0.0
    for load in system.loads:
        i = system.root_of(load.body)
        if i not in system.row:
            continue
        a, b = last.rigid[system.row[i]], rows[system.row[i]]
        before, _ = load_on_body(load, last.bodies.poses[i], model.origins[i], last.time)
        now, _ = load_on_body(load, poses[i], model.origins[i], time)
        mean = 0.5 * (a[VELOCITY : VELOCITY + 3] + b[VELOCITY : VELOCITY + 3])
        path = b[CENTRE : CENTRE + 3] - a[CENTRE : CENTRE + 3]
        work += 0.5 * float(((before + now) * ((time - last.time) * mean - path)).sum())
    return work
