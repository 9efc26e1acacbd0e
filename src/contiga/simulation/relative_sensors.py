"""Measure between two bodies: distance, relative motion, rotation, and the springs between them."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length, product
from contiga.records import FloatArray
from contiga.rigid.frames import cross
from contiga.simulation.load_forces import point_of
from contiga.simulation.model import Model
from contiga.simulation.sensor import RATES, SPRING_MEASURES, RelativeSensor
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
    """Return the columns of all sensors between two bodies; `last` is the state before `state`."""
    columns: dict[str, float] = {}
    for sensor in model.relative:
        columns |= between_columns(model, sensor, state, last)
    return columns


def between_columns(
    model: Model, sensor: RelativeSensor, state: SystemState, last: SystemState | None
) -> dict[str, float]:
    """Return the columns of the measures of one sensor, by name; `last` is None at the start.

    Displacement and angle are relative to the start. Force and moment are those of springs between
    the two bodies on the first body, the moment about its point.
    """
    roots = [model.mechanism.root_of(body) for body in sensor.between]
    starts = [model.origins[i] for i in roots]
    poses = [state.bodies.poses[i] for i in roots]
    firsts = [
        first_place(model, i, None if sensor.at is None else sensor.at[k])
        for k, i in enumerate(roots)
    ]
    places = [point_of(poses[k], starts[k], firsts[k]) for k in (0, 1)]
    values: dict[str, float] = {}
    arm = places[1] - places[0]
    if "distance" in sensor.measures:
        speeds = [point_velocity(state, roots[k], places[k]) for k in (0, 1)]
        # At distance zero the rate is the speed of separation.
        distance, speed = length(arm), speeds[1] - speeds[0]
        rate = float((arm * speed).sum()) / distance if distance > 0.0 else length(speed)
        values |= {"distance": distance, "rate": rate}
    if "displacement" in sensor.measures:
        now, before = arm, firsts[1] - firsts[0]
        if sensor.turns:
            now = on_axes(sensor, poses[0], starts[0], now)
            before = on_axes(sensor, starts[0], starts[0], before)
        values |= measure_columns("", "displacement", now - before)
    if "angle" in sensor.measures:
        now, before = (product(pair[0][:3, :3].T, pair[1][:3, :3]) for pair in (poses, starts))
        turn = _rotation_vector(product(now, before.T))
        values["angle"] = length(turn)
        values |= vector_columns("angle_", from_body(sensor, starts[0], turn))
    values |= _relative_rates(model, sensor, (roots, places), (last, state))
    # Force and moment of the springs between the two on the first body, world axes.
    force, moment = np.zeros(3), np.zeros(3)
    for name, spring in model.springs.items():
        spring_state = state.springs.get(name)
        if spring_state is not None and set(spring.between) == set(sensor.between):
            end = spring.between.index(sensor.between[0])
            pull = -spring_state.pull if end else spring_state.pull
            force = force + pull
            moment = moment + cross(spring_state.ends[end] - places[0], pull)
    for measure, world in zip(SPRING_MEASURES, (force, moment), strict=True):
        if measure in sensor.measures:
            if sensor.turns:
                world = on_axes(sensor, poses[0], starts[0], world)
            values |= measure_columns("", measure, world)
    return {f"{sensor.name}.{name}": value for name, value in values.items()}


_StatePair = tuple[SystemState | None, SystemState]


def _relative_rates(
    model: Model, sensor: RelativeSensor, ends: tuple[list[int], list[FloatArray]], step: _StatePair
) -> dict[str, float]:
    """Return the columns of velocity and acceleration of the second point relative to the first.

    `ends` are the numbers of both bodies and the points on them, `step` the states before and after
    a step. Names of columns have no prefix; only measures of the sensor are returned.

    In axes of the first body they are those that an observer rotating with it sees; in world axes
    they are the differences between the two points.
    """
    ((i, j), (first_point, second_point)), state = ends, step[1]
    values: dict[str, float] = {}
    in_body_axes = sensor.turns
    spin = state.bodies.twists[i, 3:] if in_body_axes else np.zeros(3)
    velocity = point_velocity(state, j, second_point) - point_velocity(state, i, first_point)
    velocity = velocity - cross(spin, second_point - first_point)
    for measure in RATES:
        if measure not in sensor.measures:
            continue
        value = velocity
        if measure == "acceleration":
            value = point_acceleration(model, j, second_point, step)
            value = (
                value
                - point_acceleration(model, i, first_point, step)
                - 2.0 * cross(spin, velocity)
            )
            if in_body_axes:
                spin_rate = acceleration(model, i, state, step[0])[1]
                arm = second_point - first_point
                value = value - cross(spin_rate, arm) - cross(spin, cross(spin, arm))
        if in_body_axes:
            value = on_axes(sensor, state.bodies.poses[i], model.origins[i], value)
        values |= measure_columns("", measure, value)
    return values


def _rotation_vector(R: FloatArray) -> FloatArray:
    """Return the rotation vector (3,) of a matrix (3, 3): the axis times the angle, from 0 to π.

    At half a turn either sense of the axis may be returned.
    """
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = length(axis), 0.5 * (float(np.trace(R)) - 1.0)
    if sine > 1e-8 or cosine > 0.0:
        angle = float(np.arctan2(sine, cosine))
        return axis * (angle / sine) if sine > 0.0 else axis
    # Half a turn: the axis is the longest column of R + 1.
    both = R + np.eye(3)
    column = both[:, int(np.argmax(np.diag(both)))]
    return np.asarray(np.pi * column / length(column))
