"""What sensors between two bodies say: how far apart points of them are, how they move and turn,
and what the springs between them carry."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.records import FloatArray
from contiga.rigid.frames import cross
from contiga.simulation.load_forces import point_of
from contiga.simulation.model import Model
from contiga.simulation.sensor import CUT, RATES, RelativeSensor
from contiga.simulation.sensors import (
    acceleration,
    first_place,
    from_body,
    measure_columns,
    on_axes,
    point_acceleration,
    point_velocity,
    vector_columns,
)
from contiga.simulation.system_state import SystemState


def relative_columns(
    model: Model, state: SystemState, last: SystemState | None
) -> dict[str, float]:
    """What sensors between two bodies say of `state`; `last` is the state before it."""
    columns: dict[str, float] = {}
    for sensor in model.relative:
        columns |= between_columns(model, sensor, state, last)
    return columns


def between_columns(
    model: Model, sensor: RelativeSensor, state: SystemState, last: SystemState | None
) -> dict[str, float]:
    """Return the columns of one sensor."""
    roots = [model.mechanism.root_of(body) for body in sensor.between]
    starts = [model.origins[i] for i in roots]
    poses = [state.bodies.poses[i] for i in roots]
    firsts = [
        first_place(model, i, None if sensor.at is None else sensor.at[k])
        for k, i in enumerate(roots)
    ]
    places = [point_of(poses[k], starts[k], firsts[k]) for k in (0, 1)]
    values: dict[str, float] = {}
    way = places[1] - places[0]
    if "distance" in sensor.measures:
        speeds = [point_velocity(state, roots[k], places[k]) for k in (0, 1)]
        # The rate is that of the approach where the distance is zero.
        far, speed = length(way), speeds[1] - speeds[0]
        rate = float((way * speed).sum()) / far if far > 0.0 else length(speed)
        values |= {"distance": far, "rate": rate}
    if "displacement" in sensor.measures:
        now, before = way, firsts[1] - firsts[0]
        if sensor.turns:
            now = on_axes(sensor, poses[0], starts[0], now)
            before = on_axes(sensor, starts[0], starts[0], before)
        values |= measure_columns("", "displacement", now - before)
    if "angle" in sensor.measures:
        now, before = (product(pair[0][:3, :3].T, pair[1][:3, :3]) for pair in (poses, starts))
        turn = _turned(product(now, before.T))
        values["angle"] = length(turn)
        values |= vector_columns("angle_", from_body(sensor, starts[0], turn))
    values |= _rates(model, sensor, (roots, places), (last, state))
    # What the springs between the two carry: on the first of them, world axes.
    force, moment = np.zeros(3), np.zeros(3)
    for name, spring in model.springs.items():
        carried = state.springs.get(name)
        if carried is not None and set(spring.between) == set(sensor.between):
            end = spring.between.index(sensor.between[0])
            pull = -carried.pull if end else carried.pull
            force = force + pull
            moment = moment + cross(carried.ends[end] - places[0], pull)
    for measure, world in zip(CUT, (force, moment), strict=True):
        if measure in sensor.measures:
            if sensor.turns:
                world = on_axes(sensor, poses[0], starts[0], world)
            values |= measure_columns("", measure, world)
    return {f"{sensor.name}.{name}": value for name, value in values.items()}


_Step = tuple[SystemState | None, SystemState]


def _rates(
    model: Model, sensor: RelativeSensor, ends: tuple[list[int], list[FloatArray]], step: _Step
) -> dict[str, float]:
    """How the second point moves: in the axes of the first body as one on it sees it, who turns
    with it; along those of the world the difference of the two."""
    ((i, j), (here, there)), state = ends, step[1]
    values: dict[str, float] = {}
    on_body = sensor.turns
    spin = state.bodies.twists[i, 3:] if on_body else np.zeros(3)
    velocity = point_velocity(state, j, there) - point_velocity(state, i, here)
    velocity = velocity - cross(spin, there - here)
    for measure in RATES:
        if measure not in sensor.measures:
            continue
        value = velocity
        if measure == "acceleration":
            value = point_acceleration(model, j, there, step)
            value = value - point_acceleration(model, i, here, step) - 2.0 * cross(spin, velocity)
            if on_body:
                turning = acceleration(model, i, state, step[0])[1]
                way = there - here
                value = value - cross(turning, way) - cross(spin, cross(spin, way))
        if on_body:
            value = on_axes(sensor, state.bodies.poses[i], model.origins[i], value)
        values |= measure_columns("", measure, value)
    return values


def _turned(R: FloatArray) -> FloatArray:
    """(3,) the axis of a rotation times its angle, radians from 0 to π."""
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = length(axis), 0.5 * (float(np.trace(R)) - 1.0)
    if sine > 1e-8 or cosine > 0.0:
        angle = float(np.arctan2(sine, cosine))
        return axis * (angle / sine) if sine > 0.0 else axis
    # Half a turn: its axis is the column of (R + 1) that is longest.
    both = R + np.eye(3)
    column = both[:, int(np.argmax(np.diag(both)))]
    return np.asarray(np.pi * column / length(column))
