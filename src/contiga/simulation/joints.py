"""Joints of a simulation: where a step has them, and what the history says of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.dynamics.linkage import OPEN, JointStates
from contiga.dynamics.prescribed import is_told
from contiga.dynamics.rigid_bodies import Placed
from contiga.errors import RunError
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.system_state import BodyStates, SystemState

OF_REACTIONS = ("fx", "fy", "fz", "mx", "my", "mz")
"""Columns of a joint: the force that it puts on its second body, and the moment about its point,
world axes, without its laws; and each coordinate under its own name."""
OF_JOINT_LAWS = ("force", "energy_stored", "energy_hysteresis", "energy_damping", "energy_friction")
"""Columns of a law, ``<joint>.<coordinate>_<column>``: moment or force against the coordinate, what
it would give back, and what it has lost since the start."""
NUDGE = 1e-6
"""Part of the time of a run over which the acceleration of a driven body is taken at its start."""


def close_joints(
    model: Model, last: SystemState, free: Placed, poses: FloatArray, time: float
) -> None:
    """Correct a drift of free bodies from `last` so that all joints are closed at `time`.

    Raises
    ------
    RunError
        They do not close: a driven body pulls its joints apart, or the step is too long.
    """
    off = model.linkage.close(last.rigid, last.bodies.poses, free, poses, time - last.time)
    if not off <= OPEN:
        name, gap = model.linkage.worst(free, poses)
        raise RunError(
            f"t = {time:g}: joint {name!r} does not close, {gap:.4g} is left (length, or sine of "
            "an angle): its bodies are driven or held where it cannot follow, or the step of "
            f"{time - last.time:.4g} is too long for how fast they turn"
        )


def joint_states(model: Model, last: SystemState | None, bodies: BodyStates) -> JointStates:
    """Return all joints where their bodies are now, with what their laws do; reactions are those
    before. Without laws nothing is asked before the forces are known, and all is as it was."""
    before = None if last is None else last.joints
    if before is not None and not model.linkage.laws:
        return before
    now = model.linkage.measured(before, bodies.poses, bodies.twists)
    return model.linkage.with_laws(before, now)


def reacting(
    model: Model,
    last: SystemState | None,
    states: JointStates,
    free: Placed,
    bodies: BodyStates,
    time: float,
    total: FloatArray,
) -> tuple[float, JointStates]:
    """End the kick of a step: velocities that joints allow, and their reactions, which are added to
    the wrenches `total` (n, 6).

    Returns
    -------
    tuple
        The kinetic energy, and the joints with reactions and rates at the end of the step.
    """
    linkage, system = model.linkage, model.mechanism
    accelerations = np.zeros((len(system.index), 6))
    for i in linkage.bodies & system.driven.keys():
        accelerations[i] = driven_acceleration(model, i, last, bodies, time)
    kinetic, reactions = linkage.react(free, bodies.poses, bodies.twists, accelerations)
    twists = bodies.twists.copy()
    twists[system.free] = free.twists
    now = linkage.measured(states, bodies.poses, twists[system.root])
    now = now._replace(reactions=reactions)
    linkage.add_reactions(now, bodies.poses, total)
    return kinetic, now


def driven_acceleration(
    model: Model, i: int, last: SystemState | None, bodies: BodyStates, time: float
) -> FloatArray:
    """(6,) acceleration of the frame of a driven body, and its angular acceleration.

    A motion that does not tell it is asked for its twists half a step before and after, so that
    accelerations add up to what velocities change by, also where these jump; at the end of the run
    and at its start on one side. One that may not be asked at other times has the mean of the last
    step.
    """
    motion, now = model.mechanism.driven[i], bodies.twists[i]
    if hasattr(motion, "acceleration"):
        return np.concatenate([motion.acceleration(time), np.zeros(3)])
    if last is None:
        if not is_told(motion):
            return np.zeros(6)
        way = NUDGE * (model.stepping.end - model.stepping.start)
        after = np.concatenate(motion.twist(time + way))
        return np.asarray((after - now) / way)
    dt = time - last.time
    if not is_told(motion):
        return np.asarray((now - last.bodies.twists[i]) / dt)
    earlier, later = time - 0.5 * dt, max(time, min(time + 0.5 * dt, model.stepping.end))
    change = np.concatenate(motion.twist(later)) - np.concatenate(motion.twist(earlier))
    return np.asarray(change / (later - earlier))


def joint_columns(model: Model, state: SystemState) -> dict[str, float]:
    """What a row of the history says of all joints: ``<joint>.fx`` and so on."""
    joints, columns = state.joints, dict[str, float]()
    if joints is None:
        return columns
    linkage = model.linkage
    for name, reaction in zip(linkage.names, joints.reactions.tolist(), strict=True):
        for column, value in zip(OF_REACTIONS, reaction, strict=True):
            columns[f"{name}.{column}"] = value
    for (name, coordinate), value in zip(linkage.coordinates, joints.values.tolist(), strict=True):
        columns[f"{name}.{coordinate}"] = value
    for k, (name, coordinate, _, _) in enumerate(linkage.laws):
        law = joints.law(k)
        values = law.force, law.stored, law.hysteresis, law.damping, law.friction
        for column, value in zip(OF_JOINT_LAWS, values, strict=True):
            columns[f"{name}.{coordinate}_{column}"] = value
    return columns


def joint_summary(model: Model) -> dict[str, dict[str, Any]]:
    """Return what a reader of the files needs to know of joints, by name."""
    return {
        name: {"kind": joint.kind, "between": list(joint.between)}
        for name, joint in model.joints.items()
    }
