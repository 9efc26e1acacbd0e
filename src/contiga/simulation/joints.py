"""Advance the joints of a simulation in a step, and write their columns of the history."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.ordered import product
from contiga.dynamics.joints import KINDS
from contiga.dynamics.linkage import OPEN, JointStates
from contiga.dynamics.prescribed import is_known_ahead
from contiga.dynamics.rigid_bodies import Placed, bodies_at_start
from contiga.dynamics.springs import GROUND
from contiga.errors import RunError
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.system_state import BodyStates, SystemState

REACTION_COLUMNS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Columns of a joint, ``<joint>.<column>``: reaction force on its second body, and moment about its
point there, world axes, without its laws."""
JOINT_LAW_COLUMNS = (
    "force",
    "energy_stored",
    "energy_hysteresis",
    "energy_damping",
    "energy_friction",
)
"""Columns of a law, ``<joint>.<coordinate>_<column>``: moment or force that opposes the coordinate,
energy stored, and energies lost since the start."""
START_STEP = 1e-6
"""Step of the difference, as a share of the run's duration, for the acceleration of a driven body
at the start."""


class JointReactions(NamedTuple):
    """Joints and kinetic energy at the end of a step."""

    kinetic: float
    """Kinetic energy of the free bodies."""
    states: JointStates
    """Joints with their reactions, and rates at the end of the step."""


def close_joints(
    model: Model, last: SystemState, free: Placed, poses: FloatArray, time: float
) -> None:
    """Correct the drift of the bodies `free` from `last` to `time`, in place, so that joints close.

    `poses` (n, 4, 4) are those of driven bodies at `time`.

    Raises
    ------
    RunError
        A joint stays open: a driven body pulls it apart, or the step is too long.
    """
    misfit = model.linkage.close(last.rigid, last.bodies.poses, free, poses, time - last.time)
    if not misfit <= OPEN:
        worst = model.linkage.worst(free, poses)
        raise RunError(
            f"t = {time:g}: joint {worst.joint!r} does not close, a misfit of {worst.gap:.4g} "
            "(length, or sine of an angle) remains: its bodies are driven or held where it cannot "
            f"follow, or they turn too fast for the step of {time - last.time:.4g}"
        )


def joint_states(model: Model, last: SystemState | None, bodies: BodyStates) -> JointStates:
    """Return all joints at the present poses of their bodies, with their laws advanced.

    Reactions are those of `last`. Without laws the state of `last` is returned, as no force depends
    on it.
    """
    before = None if last is None else last.joints
    if before is not None and not model.linkage.laws:
        return before
    now = model.linkage.measured(before, bodies.poses, bodies.twists)
    return model.linkage.with_laws(before, now)


def react_joints(
    model: Model,
    last: SystemState | None,
    states: JointStates,
    free: Placed,
    bodies: BodyStates,
    time: float,
    total: FloatArray,
) -> JointReactions:
    """End the kick of a step: project the velocities of `free` onto the constraints, in place.

    `states` are the joints before; reactions are added to the forces in `free.rows` and to the
    wrenches `total` (n, 6), in place. Returned are the kinetic energy of the free bodies, and the
    joints with reactions and rates at the end of the step.
    """
    linkage, system = model.linkage, model.mechanism
    accelerations = np.zeros((len(system.index), 6))
    for i in linkage.bodies & system.driven.keys():
        accelerations[i] = driven_acceleration(model, i, last, bodies, time)
    reaction = linkage.react(free, bodies.poses, bodies.twists, accelerations)
    twists = bodies.twists.copy()
    twists[system.free] = free.twists
    now = linkage.measured(states, bodies.poses, twists[system.root])
    now = now._replace(reactions=reaction.reactions)
    linkage.add_reactions(now, bodies.poses, total)
    return JointReactions(reaction.kinetic, now)


def driven_acceleration(
    model: Model, i: int, last: SystemState | None, bodies: BodyStates, time: float
) -> FloatArray:
    """Return the acceleration (6,) of the frame of driven body i, linear and angular, world axes.

    A motion that knows its acceleration does not turn. Any other is differenced over its twists
    half a step before and after, so that the accelerations add up to the change of velocity even
    across a jump; at the start and at the end of the run the difference is one-sided. A motion that
    is known only up to now has the mean acceleration of the last step, zero at the start.
    """
    motion, now = model.mechanism.driven[i], bodies.twists[i]
    if hasattr(motion, "acceleration"):
        return np.concatenate([motion.acceleration(time), np.zeros(3)])
    if last is None:
        if not is_known_ahead(motion):
            return np.zeros(6)
        step = START_STEP * (model.stepping.end - model.stepping.start)
        after = np.concatenate(motion.twist(time + step))
        return np.asarray((after - now) / step)
    dt = time - last.time
    if not is_known_ahead(motion):
        return np.asarray((now - last.bodies.twists[i]) / dt)
    earlier, later = time - 0.5 * dt, max(time, min(time + 0.5 * dt, model.stepping.end))
    change = np.concatenate(motion.twist(later)) - np.concatenate(motion.twist(earlier))
    return np.asarray(change / (later - earlier))


def joint_columns(model: Model, state: SystemState) -> dict[str, float]:
    """Return the history columns of all joints by name, ``<joint>.fx`` and so on."""
    joints, columns = state.joints, dict[str, float]()
    if joints is None:
        return columns
    linkage = model.linkage
    for name, reaction in zip(linkage.names, joints.reactions.tolist(), strict=True):
        for column, value in zip(REACTION_COLUMNS, reaction, strict=True):
            columns[f"{name}.{column}"] = value
    for coordinate, value in zip(linkage.coordinates, joints.values.tolist(), strict=True):
        columns[f"{coordinate.joint}.{coordinate.name}"] = value
    for k, entry in enumerate(linkage.laws):
        law = joints.law(k)
        values = law.force, law.stored, law.hysteresis, law.damping, law.friction
        for column, value in zip(JOINT_LAW_COLUMNS, values, strict=True):
            columns[f"{entry.joint}.{entry.coordinate}_{column}"] = value
    return columns


def joint_summary(model: Model) -> dict[str, dict[str, Any]]:
    """Return the kind, the bodies and the lines of each joint, by name, for the summary file."""
    lines = joint_lines(model)
    return {
        name: {
            "kind": joint.kind,
            "between": list(joint.between),
            "lines": lines[name].tolist(),
        }
        for name, joint in model.joints.items()
    }


def joint_lines(model: Model) -> dict[str, FloatArray]:
    """Return the lines (k, 2, 3) that draw each joint at the start, by name.

    The lines are its axis through the marker on its second body, both axes of a universal joint, or
    a cross for a joint without an axis. They are as long as the smaller of its bodies.
    """
    if not model.joints:
        return {}
    table, poses = model.linkage.table, model.origins.copy()
    poses[model.mechanism.free] = bodies_at_start(model.joint_fit.rows, model.mechanism.fixed).poses
    lines = {}
    for g, (name, joint) in enumerate(model.joints.items()):
        half = 0.5 * min(model.bodies[b].body.size for b in joint.between if b != GROUND)
        point, axes = table.points_B[g, 1], table.axes_B[g, 1]
        if (body := table.bodies[g, 1]) >= 0:
            point = product(poses[body, :3, :3], point) + poses[body, :3, 3]
            axes = product(axes, poses[body, :3, :3].T)
        drawn = {0: axes, 1: axes[2:], 2: axes[[0, 2]]}[KINDS[joint.kind].axes]
        lines[name] = np.stack([point - half * drawn, point + half * drawn], axis=1)
    return lines
