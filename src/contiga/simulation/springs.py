"""Springs of a simulation: where a step has them, and what the history and the summary say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contiga.dynamics.nodes import SlaveState
from contiga.dynamics.springs import SpringState
from contiga.records import FloatArray
from contiga.rigid.frames import cross
from contiga.simulation.load_forces import point_of
from contiga.simulation.mechanism import Mechanism
from contiga.simulation.model import Model
from contiga.simulation.sensors import point_velocity
from contiga.simulation.system_state import BodyStates, SystemState

OF_SPRINGS = (
    *("force", "elongation", "rate"),
    *("energy_stored", "energy_hysteresis", "energy_damping"),
)
"""Columns of a spring: tension with its damper, how much longer it is than at rest and how fast it
lengthens, what it would give back, and what it has lost since the start."""


def spring_states(
    model: Model,
    last: Mapping[str, SpringState] | None,
    bodies: BodyStates,
    slaves: Mapping[str, SlaveState],
) -> dict[str, SpringState]:
    """All springs where their ends are now, after the `last` states; None at the start."""
    states = {}
    for name, spring in model.mechanism.springs.items():
        ends, velocities = np.empty((2, 3)), np.zeros((2, 3))
        for k, (i, slave, node) in enumerate(model.mechanism.ends[name]):
            ends[k] = spring.at[k]
            if i is not None:
                pose, twist = bodies.poses[i], bodies.twists[i]
                ends[k] = point_of(pose, model.origins[i], spring.at[k])
                velocities[k] = twist[:3] + cross(twist[3:], ends[k] - pose[:3, 3])
            elif slave is not None:
                ends[k], velocities[k] = (part[node] for part in slaves[slave])
        if last is None:
            states[name] = spring.start(ends, velocities)
        else:
            states[name] = spring.step(last[name], ends, velocities)
    return states


def add_pulls(
    system: Mechanism, springs: Mapping[str, SpringState], poses: FloatArray, total: FloatArray
) -> None:
    """Add what springs do to the wrenches (n, 6) on bodies at `poses` (n, 4, 4)."""
    for name, spring in springs.items():
        for k, (i, _, _) in enumerate(system.ends[name]):
            if i is not None:
                pull = spring.pull if k == 0 else -1.0 * spring.pull
                total[i, :3] += pull
                total[i, 3:] += cross(spring.ends[k] - poses[i, :3, 3], pull)


def spring_columns(model: Model, state: SystemState) -> dict[str, float]:
    """What a row of the history says of all springs: ``<spring>.force`` and so on."""
    columns: dict[str, float] = {}
    for name, spring in model.mechanism.springs.items():
        now, rate = state.springs[name], 0.0
        if now.length > 0.0:  # how fast it lengthens, at the end of the step; the ground stands
            speeds = []
            for k, (i, slave, node) in enumerate(model.mechanism.ends[name]):
                if slave is not None:
                    speeds.append(state.slaves[slave].velocities[node])
                else:
                    at = now.ends[k]
                    speeds.append(np.zeros(3) if i is None else point_velocity(state, i, at))
            along = (now.ends[1] - now.ends[0]) / now.length
            rate = float(np.sum(along * (speeds[1] - speeds[0])))
        values = (
            now.force,
            now.length - spring.length,
            rate,
            now.stored,
            now.hysteresis,
            now.damping,
        )
        columns |= {f"{name}.{c}": float(v) for c, v in zip(OF_SPRINGS, values, strict=True)}
    return columns


def spring_summary(model: Model) -> dict[str, dict[str, Any]]:
    """What a reader of the files needs to know of the springs, by name."""
    return {
        name: {"between": list(spring.between), "at": spring.at.tolist(), "filter": spring.filter}
        for name, spring in model.springs.items()
    }
