"""Evaluate injury criteria of a whole run, each on the signal that its source asks for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from contiga.arrays.ordered import length
from contiga.criteria.brain import CRITICAL, bric
from contiga.criteria.chest import LEAST, vc
from contiga.criteria.dummies import DUMMIES
from contiga.criteria.femur import femur_force
from contiga.criteria.head_injury import hic, hicd
from contiga.criteria.held_level import clip
from contiga.criteria.neck import nij
from contiga.io.units import acceleration_factor, base_factor
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.sensor import CRITERION_UNITS, OWN_FILTERS, RelativeSensor, Sensor
from contiga.simulation.sensors import on_axes
from contiga.simulation.signals import smooth, too_coarse
from contiga.simulation.slave_sensor import slave_of
from contiga.simulation.springs import first_time

History = dict[str, FloatArray]
Found = dict[str, Any]
"""`value`, and `start` and `end` of when it holds, seconds."""
_WINDOWS = {"HIC15": 0.015, "HIC36": 0.036, "HICd": 0.036}
_HELD = 0.003
_COLUMNS = {"BrIC": ("wx", "wy", "wz"), "VC": ("distance",), "Nij": ("fz", "my"),
            "femur": ("fx", "fy", "fz")}  # fmt: skip
"""What criteria with filters of their own are of."""


def sensor_summary(model: Model, history: History) -> dict[str, dict[str, Any]]:
    """Return the criteria of all sensors over the whole run, by name.

    They have values, bands, and the times when they hold, in the time unit of the case.
    """
    summary = sensors_told(model, history)
    judged: list[Sensor | RelativeSensor] = [*model.point_sensors, *model.relative]
    if len(history["time"]) < 2:
        return summary
    for sensor in judged:
        if not sensor.criteria:
            continue
        found = dict(_of_acceleration(model, sensor, history)) if isinstance(sensor, Sensor) else {}
        for name in sensor.criteria:  # whose source says how the signal is to be filtered
            columns = [f"{sensor.name}.{column}" for column in _COLUMNS.get(name, ())]
            if not columns or too_coarse(model, OWN_FILTERS[name], history):
                continue
            if not all(np.isfinite(history[column]).all() for column in columns):
                continue
            grid, signal = smooth(model, columns, OWN_FILTERS[name], history)
            if name != "VC" or len(grid) >= LEAST:
                found[name] = _found(model, sensor, name, grid, signal)
        unit, criteria = base_factor(model.units[2], "time"), summary[sensor.name]["criteria"]
        for name in sensor.criteria:
            if name not in found:
                continue
            one = found[name]
            criteria[name] = {**one, "start": one["start"] / unit, "end": one["end"] / unit}
            if name in CRITERION_UNITS:
                criteria[name]["unit"] = CRITERION_UNITS[name]
            if name in sensor.bands:
                criteria[name]["band"] = sensor.bands[name].of(one["value"])
    return summary


def sensors_told(model: Model, history: History) -> dict[str, dict[str, Any]]:
    """Return the summary of sensors for a run that has no criteria yet.

    A trigger has the time of the first row that finds it fired, None where it never does.
    """
    summary: dict[str, dict[str, Any]] = {
        one.name: {"body": one.body, "filter": one.filter} for one in model.point_sensors
    }
    for pair in model.relative:
        summary[pair.name] = {"body": " – ".join(pair.between), "filter": None}
    for on_slave in model.slave_sensors:
        summary[on_slave.name] = {"body": slave_of(on_slave), "filter": None}
    for sensor in model.sensors:
        summary[sensor.name]["criteria"] = {}
        if sensor.code is not None:
            summary[sensor.name]["code"] = sensor.code
    for trigger in model.triggered:
        summary[trigger.name]["fired"] = first_time(history, f"{trigger.name}.fired")
    return summary


def _of_acceleration(model: Model, sensor: Sensor, history: History) -> Iterator[tuple[str, Found]]:
    """Yield criteria of the resultant acceleration, as the sensor filters it."""
    asked = [name for name in sensor.criteria if name not in OWN_FILTERS]
    if not asked or f"{sensor.name}.a" not in history:
        return
    if sensor.filter is None:
        times, acceleration = history["time"], history[f"{sensor.name}.a"]
    elif too_coarse(model, sensor.filter, history):
        return
    else:
        columns = [f"{sensor.name}.a{axis}" for axis in "xyz"]
        times, filtered = smooth(model, columns, sensor.filter, history)
        acceleration = np.array([length(row) for row in filtered])
    length_unit, _, time_unit = model.units
    a = acceleration / acceleration_factor("g", length_unit, time_unit)
    t = times * base_factor(time_unit, "time")
    if not np.isfinite(a).all():
        return
    for name in asked:
        if name in ("3ms", "chest3ms"):
            if t[-1] - t[0] < _HELD:
                continue
            value, start, end = clip(a, t, _HELD, cumulative=name == "chest3ms")[:3]
        else:
            value, start, end = hic(a, t, _WINDOWS[name])
            value = hicd(value) if name == "HICd" else value
        yield name, {"value": value, "start": start, "end": end}


def _found(
    model: Model,
    sensor: Sensor | RelativeSensor,
    name: str,
    grid: FloatArray,
    signal: FloatArray,
) -> Found:
    """Return one criterion of its signal (m, k) at even times, in units of the case."""
    metre, kilogram, second = (
        base_factor(unit, kind)
        for unit, kind in zip(model.units, ("length", "mass", "time"), strict=True)
    )
    t, newton = grid * second, kilogram * metre / second**2
    if isinstance(sensor, Sensor):
        w = signal / second
        k = int(np.argmax((np.abs(w) / CRITICAL).max(axis=1)))
        return {"value": bric(w).value, "start": t[k], "end": t[k]}
    dummy = DUMMIES[sensor.dummy]
    if name == "VC":
        pressed = (signal[0, 0] - signal[:, 0]) * metre
        value, after = vc(
            pressed, float(t[1] - t[0]), scale=dummy.chest_scale, depth=dummy.chest_depth
        )
        return {"value": value, "start": t[0] + after, "end": t[0] + after}
    if name == "Nij":
        assert dummy.neck is not None
        value, k, mode = nij(signal[:, 0] * newton, signal[:, 1] * newton * metre, dummy.neck)
        return {"value": value, "start": t[k], "end": t[k], "mode": mode}
    force = femur_force(signal @ _first_axis(model, sensor) * newton, t)
    k = int(np.argmin(signal @ _first_axis(model, sensor)))
    return {
        "value": force.ratio,
        "start": t[k],
        "end": t[k],
        "peak": force.peak,
        "held": force.held,
    }


def _first_axis(model: Model, sensor: RelativeSensor) -> FloatArray:
    """Return the direction (3,) from the first point to the second at the start, sensor axes."""
    origin = model.origins[model.mechanism.root_of(sensor.between[0])]
    assert sensor.at is not None
    way = on_axes(sensor, origin, origin, sensor.at[1] - sensor.at[0])
    return np.asarray(way / length(way))
