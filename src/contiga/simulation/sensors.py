"""Measure at each step: motions of points, forces on bodies, and forces in elements."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.ordered import length, product, solve
from contiga.records import FloatArray
from contiga.rigid import quaternion
from contiga.rigid import rigid_lanes as lanes
from contiga.rigid.frames import cross
from contiga.simulation.load_forces import point_of
from contiga.simulation.model import Model
from contiga.simulation.sensor import RelativeSensor, Sensor
from contiga.simulation.slave_sensor import NodeSensor, slave_of
from contiga.simulation.system_state import SystemState

_LETTERS = {
    "acceleration": "a",
    "velocity": "v",
    "displacement": "",
    "force": "f",
    "moment": "m",
    "spin": "w",
}
_WITH_MAGNITUDE = ("acceleration", "velocity", "force")


def sensor_columns(model: Model, state: SystemState, last: SystemState | None) -> dict[str, float]:
    """Return the columns of all sensors on one body; `last` is the state before, None at first."""
    columns: dict[str, float] = {}
    for sensor in model.point_sensors:
        columns |= point_columns(model, sensor, state, last)
    return columns


def point_columns(
    model: Model, sensor: Sensor, state: SystemState, last: SystemState | None
) -> dict[str, float]:
    """Return the columns of the measures of one sensor, along its axes.

    Force and moment are of all that acts on the body, the moment about the point.
    """
    columns: dict[str, float] = {}
    i = model.mechanism.root_of(sensor.body)
    pose, twist = state.bodies.poses[i], state.bodies.twists[i]
    first = first_place(model, i, sensor.at)
    place = point_of(pose, model.origins[i], first)
    for measure in sensor.measures:
        if measure == "acceleration":
            value = point_acceleration(model, i, place, (last, state))
        elif measure == "velocity":
            value = point_velocity(state, i, place)
        elif measure == "displacement":
            value = place - first
        elif measure == "spin":
            value = twist[3:]
        elif measure == "force":
            value = state.wrenches[i, :3]
        else:
            arm = place - pose[:3, 3]
            value = state.wrenches[i, 3:] - cross(arm, state.wrenches[i, :3])
        if sensor.turns:
            value = on_axes(sensor, pose, model.origins[i], value)
        columns |= measure_columns(f"{sensor.name}.", measure, value)
    return columns


def on_axes(
    sensor: Sensor | RelativeSensor, pose: FloatArray, origin: FloatArray, vector: FloatArray
) -> FloatArray:
    """Return the components (3,) of a world vector along the axes of a sensor on a body.

    The body's frame is at `pose` and was at `origin` (4, 4) at the start.
    """
    return from_body(sensor, origin, product(pose[:3, :3].T, vector))


def from_body(
    sensor: Sensor | RelativeSensor, origin: FloatArray, vector: FloatArray
) -> FloatArray:
    """Return the components (3,) along a sensor's axes of a vector in the frame of its body.

    The frame was at `origin` (4, 4) at the start. For axes "body" or "world" the vector stays.
    """
    if isinstance(sensor.axes, str):
        return vector
    return product(sensor.axes, product(origin[:3, :3], vector))


def slave_columns(model: Model, state: SystemState) -> dict[str, float]:
    """Return the columns of all sensors of slaves, world axes.

    A node has its velocity, and its displacement from the slave's points as given; a section has
    the sum of the forces in elements on its nodes, and their moment about its first point.
    """
    columns: dict[str, float] = {}
    for sensor in model.slave_sensors:
        name, nodes = slave_of(sensor), model.sensor_nodes[sensor.name]
        now = state.slaves[name]
        for measure in sensor.measures:
            if isinstance(sensor, NodeSensor):
                node = nodes[0]
                if measure == "velocity":
                    values = np.asarray(now.velocities[node])
                else:
                    values = np.asarray(now.points[node] - model.slaves[name].slave.points[node])
            else:
                force = now.matter["force"][nodes]
                if measure == "moment":
                    force = np.cross(now.points[nodes] - sensor.plane[0], force)
                values = np.asarray(force.sum(axis=0))
            columns |= measure_columns(f"{sensor.name}.", measure, values)
    return columns


def measure_columns(owner: str, measure: str, values: FloatArray) -> dict[str, float]:
    """Return the columns of a vector (3,) with the prefix `owner`, and its magnitude for some."""
    name = owner + _LETTERS[measure]
    columns = vector_columns(name, values)
    return columns | {name: length(values)} if measure in _WITH_MAGNITUDE else columns


def vector_columns(name: str, values: FloatArray) -> dict[str, float]:
    """Return the three columns of a vector (3,)."""
    return {f"{name}{axis}": float(v) for axis, v in zip("xyz", values, strict=True)}


def first_place(model: Model, i: int, at: FloatArray | None) -> FloatArray:
    """Return the point (3,) of a sensor at the start: `at`, or its default if that is None.

    This is the centre of mass of a free body, and the origin of the frame of any other.
    """
    if at is not None:
        return at
    row = model.mechanism.row.get(i)
    if row is None:
        return np.asarray(model.origins[i, :3, 3])
    return np.asarray(model.mechanism.start[row, lanes.CENTRE : lanes.CENTRE + 3])


def point_velocity(state: SystemState, i: int, place: FloatArray) -> FloatArray:
    """Return the velocity (3,) of a point of a body, world axes."""
    pose, twist = state.bodies.poses[i], state.bodies.twists[i]
    return np.asarray(twist[:3] + cross(twist[3:], place - pose[:3, 3]))


def point_acceleration(
    model: Model, i: int, place: FloatArray, step: tuple[SystemState | None, SystemState]
) -> FloatArray:
    """Return the acceleration (3,) of a point of a body, world axes."""
    last, state = step
    linear, angular = acceleration(model, i, state, last)
    spin, arm = state.bodies.twists[i, 3:], place - state.bodies.poses[i, :3, 3]
    return np.asarray(linear + cross(angular, arm) + cross(spin, cross(spin, arm)))


def acceleration(
    model: Model, i: int, state: SystemState, last: SystemState | None
) -> tuple[FloatArray, FloatArray]:
    """Return the linear (3,) and angular (3,) acceleration of the frame of body `i`, world axes.

    The linear one is that of the origin. Those of a free body follow from the forces; its centre
    has none in held directions, and it has none about held axes. A prescribed motion that has an
    acceleration gives it, and does not turn; otherwise they are the mean of the step from `last`,
    zero at the start.
    """
    if i in model.mechanism.row:
        k = model.mechanism.row[i]
        row, fixed = state.rigid[k], model.mechanism.fixed[k]
        spin = state.bodies.twists[i, 3:]
        R = quaternion.to_matrix(row[lanes.TURN : lanes.TURN + 4])
        axes = product(R, fixed[lanes.AXES : lanes.AXES + 9].reshape(3, 3))
        moments = fixed[lanes.MOMENTS : lanes.MOMENTS + 3]
        momentum = product(axes, moments * product(axes.T, spin))
        torque = row[lanes.TORQUE : lanes.TORQUE + 3] - cross(spin, momentum)
        if fixed[lanes.FREE_ROTATIONS : lanes.FREE_ROTATIONS + 3].all():
            angular = product(axes, product(axes.T, torque) / moments)
        else:
            free: NDArray[np.intp] = np.flatnonzero(
                fixed[lanes.FREE_ROTATIONS : lanes.FREE_ROTATIONS + 3]
            )
            angular = np.zeros(3)
            if len(free):
                inertia = product(axes * moments, axes.T)
                angular[free] = solve(inertia[np.ix_(free, free)], torque[free])
        arm = state.bodies.poses[i, :3, 3] - row[lanes.CENTRE : lanes.CENTRE + 3]
        linear = (
            centre_acceleration(row, fixed) + cross(angular, arm) + cross(spin, cross(spin, arm))
        )
        return linear, angular
    motion = model.mechanism.driven.get(i)
    if motion is not None and hasattr(motion, "acceleration"):
        return motion.acceleration(state.time), np.zeros(3)
    if last is None:
        return np.zeros(3), np.zeros(3)
    change = (state.bodies.twists[i] - last.bodies.twists[i]) / state.step
    return change[:3], change[3:]


def centre_acceleration(row: FloatArray, fixed: FloatArray) -> FloatArray:
    """Return the acceleration (3,) of the centre of a free body, zero along locked axes."""
    force, free_axes = (
        row[lanes.FORCE : lanes.FORCE + 3],
        fixed[lanes.FREE_DIRECTIONS : lanes.FREE_DIRECTIONS + 3],
    )
    return np.asarray(force / fixed[lanes.MASS] * free_axes)
