"""Signals of sensors after a run: filtered accelerations, and the criteria of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.criteria.filters import LEAST_RATE, cfc
from contiga.criteria.head_injury import hic, hicd
from contiga.criteria.held_level import clip
from contiga.io.units import acceleration_factor, base_factor
from contiga.num.ordered import length
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.sensor import Sensor

FINE = 2 * LEAST_RATE
"""Samples a second for each Hz of a filter's class, where steps are of several lengths."""
MOST = 2_000_000
"""Samples a signal is brought to at most."""
_EQUAL = 1e-6
_WINDOWS = {"HIC15": 0.015, "HIC36": 0.036, "HICd": 0.036}


def filtered_columns(model: Model, history: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Filtered accelerations of sensors that ask for them, and their resultants, by column."""
    columns: dict[str, FloatArray] = {}
    for sensor in model.sensors:
        if sensor.filter is None or too_coarse(model, sensor, history):
            continue
        times = history["time"]
        grid, signal = _even(model, sensor, history)
        dt = float(grid[1] - grid[0]) * base_factor(model.units[2], "time")
        smooth = cfc(signal, dt, sensor.filter)
        own = np.stack([np.interp(times, grid, smooth[:, k]) for k in range(3)], axis=1)
        for k, axis in enumerate("xyz"):
            columns[f"{sensor.name}.filtered_a{axis}"] = own[:, k]
        columns[f"{sensor.name}.filtered_a"] = np.array([length(row) for row in own])
    return columns


def too_coarse(model: Model, sensor: Sensor, history: dict[str, FloatArray]) -> bool:
    """Whether the steps are too long for the filter of a sensor."""
    if sensor.filter is None:
        return False
    times = history["time"]
    return len(times) < 2 or float(np.diff(times).max()) > (1.0 + _EQUAL) * _sample(model, sensor)


def longest_sample(model: Model) -> float:
    """The longest step that the filters of all sensors can do with; infinite without any."""
    return min((_sample(model, s) for s in model.sensors if s.filter), default=np.inf)


def _sample(model: Model, sensor: Sensor) -> float:
    assert sensor.filter is not None
    hertz = LEAST_RATE * int(sensor.filter.removeprefix("CFC"))
    return 1.0 / (hertz * base_factor(model.units[2], "time"))


def _even(
    model: Model, sensor: Sensor, history: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Times one step apart (k,) and the acceleration there (k, 3)."""
    times = history["time"]
    signal = np.stack([history[f"{sensor.name}.a{axis}"] for axis in "xyz"], axis=1)
    steps = np.diff(times)
    if np.ptp(steps) <= _EQUAL * steps.max():
        return times, signal
    assert sensor.filter is not None
    unit = base_factor(model.units[2], "time")
    step = 1.0 / (FINE * int(sensor.filter.removeprefix("CFC"))) / unit
    step = min(step, float(np.median(steps)))
    count = min(int(np.ceil((times[-1] - times[0]) / step)), MOST)
    grid = np.linspace(times[0], times[-1], count + 1)
    return grid, np.stack([np.interp(grid, times, signal[:, k]) for k in range(3)], axis=1)


def sensor_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, dict[str, Any]]:
    """What the sensors say of the whole run: extremes and criteria, by name of the sensor."""
    return {
        sensor.name: {
            "body": sensor.body,
            "filter": sensor.filter,
            "criteria": _criteria(model, sensor, history),
        }
        for sensor in model.sensors
    }


def _criteria(
    model: Model, sensor: Sensor, history: dict[str, FloatArray]
) -> dict[str, dict[str, float]]:
    """Each criterion with its value, and when it holds, in the time unit of the case."""
    column = f"{sensor.name}.filtered_a" if sensor.filter else f"{sensor.name}.a"
    if not sensor.criteria or column not in history or len(history["time"]) < 2:
        return {}
    length_unit, _, time_unit = model.units
    a = history[column] / acceleration_factor("g", length_unit, time_unit)
    unit = base_factor(time_unit, "time")
    t = history["time"] * unit
    if not np.isfinite(a).all():
        return {}
    found: dict[str, dict[str, float]] = {}
    for name in sensor.criteria:
        if name == "3ms":
            if t[-1] - t[0] < 0.003:
                continue
            value, start, end = clip(a, t, 0.003)[:3]
        else:
            value, start, end = hic(a, t, _WINDOWS[name])
            value = hicd(value) if name == "HICd" else value
        found[name] = {"value": value, "start": start / unit, "end": end / unit}
    return found


def signal_warnings(model: Model, history: dict[str, FloatArray]) -> list[str]:
    """Filters that the steps of the run are too long for."""
    return [
        f"{sensor.name}: the steps are too long for {sensor.filter}, which needs "
        f"{LEAST_RATE} samples a second for each Hz of its class; nothing is filtered and its "
        'criteria are left out. Take smaller steps, or step = "auto" with a shorter largest one'
        for sensor in model.sensors
        if too_coarse(model, sensor, history)
    ]
