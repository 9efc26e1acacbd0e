"""What sensors of slaves say at each step."""

from __future__ import annotations

import numpy as np

from contiga.arrays.ordered import length
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.slave_sensor import NodeSensor, SlaveSensor, slave_of
from contiga.simulation.system_state import SystemState

_LETTERS = {"displacement": "", "velocity": "v", "force": "f", "moment": "m"}
_SUMMED = ("velocity", "force")


def slave_columns(model: Model, state: SystemState) -> dict[str, float]:
    """What all sensors of slaves say of `state`."""
    columns: dict[str, float] = {}
    for sensor in model.slave_sensors:
        for measure in sensor.measures:
            values, letter = _measured(model, sensor, measure, state), _LETTERS[measure]
            named = zip("xyz", values, strict=True)
            columns |= {f"{sensor.name}.{letter}{axis}": float(v) for axis, v in named}
            if measure in _SUMMED:
                columns[f"{sensor.name}.{letter}"] = length(values)
    return columns


def _measured(model: Model, sensor: SlaveSensor, measure: str, state: SystemState) -> FloatArray:
    """(3,) along the axes of the world."""
    name, nodes = slave_of(sensor), model.sensor_nodes[sensor.name]
    now = state.slaves[name]
    if isinstance(sensor, NodeSensor):
        if measure == "velocity":
            return np.asarray(now.velocities[nodes[0]])
        return np.asarray(now.points[nodes[0]] - model.slaves[name].slave.points[nodes[0]])
    force = now.matter["force"][nodes]
    if measure == "moment":
        force = np.cross(now.points[nodes] - sensor.plane[0], force)
    return np.asarray(force.sum(axis=0))
