"""Signals after a run: filtered accelerations of sensors and forces of springs, and criteria."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from contiga.criteria.filters import LEAST_RATE, cfc, memory
from contiga.criteria.head_injury import hic, hicd
from contiga.criteria.held_level import clip
from contiga.errors import ContigaWarning
from contiga.io.units import acceleration_factor, base_factor
from contiga.num.ordered import length
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.resampling import FINE, even_times, means, trapezoids
from contiga.simulation.sensor import RelativeSensor, Sensor

_EQUAL = 1e-6
_WINDOWS = {"HIC15": 0.015, "HIC36": 0.036, "HICd": 0.036}


def filtered_columns(model: Model, history: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Filtered accelerations of sensors that ask for them, with their resultants, and filtered
    forces of springs, by column."""
    columns: dict[str, FloatArray] = {}
    times = history["time"]
    for name, (cls, raw) in _filtered(model).items():
        if too_coarse(model, cls, history):
            continue
        grid, smooth = _smooth(model, name, history)
        if grid is not times:
            smooth = means(times, grid, smooth, trapezoids(grid, smooth))
        columns |= {f"{name}.filtered_{c}": smooth[:, i] for i, c in enumerate(raw)}
        if len(raw) > 1:
            columns[f"{name}.filtered_a"] = np.array([length(row) for row in smooth])
    return columns


def _filtered(model: Model) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Who asks for a filter: its class, and the columns that are filtered."""
    accelerations = ("ax", "ay", "az")
    sensors = {s.name: (s.filter, accelerations) for s in model.point_sensors if s.filter}
    springs = {name: (s.filter, ("force",)) for name, s in model.springs.items() if s.filter}
    return {**sensors, **springs}


def too_coarse(model: Model, cls: str, history: dict[str, FloatArray]) -> bool:
    """Whether the steps are too long for a filter."""
    times = history["time"]
    return len(times) < 2 or float(np.diff(times).max()) > (1.0 + _EQUAL) * _sample(model, cls)


def longest_sample(model: Model) -> float:
    """The longest step that all filters can do with; infinite without any."""
    return min((_sample(model, cls) for cls, _ in _filtered(model).values()), default=np.inf)


def _sample(model: Model, cls: str) -> float:
    hertz = LEAST_RATE * int(cls.removeprefix("CFC"))
    return 1.0 / (hertz * base_factor(model.units[2], "time"))


def _smooth(
    model: Model, name: str, history: dict[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Times one step apart (m,) and what a sensor or spring has filtered, there (m, k)."""
    cls, raw = _filtered(model)[name]
    times, unit = history["time"], base_factor(model.units[2], "time")
    signal = np.stack([history[f"{name}.{c}"] for c in raw], axis=1)
    grid = even_times(times, 1.0 / (FINE * int(cls.removeprefix("CFC"))) / unit)
    if grid is times:
        return times, _filtered_evenly(times, signal, (unit, cls))
    even = means(grid, times, signal, _impulses(model, name, history, signal))
    return grid, _filtered_evenly(grid, even, (unit, cls))


def _filtered_evenly(times: FloatArray, signal: FloatArray, how: tuple[float, str]) -> FloatArray:
    """A signal (n, k) at even times, filtered; `how` is (time unit in seconds, class)."""
    unit, cls = how
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContigaWarning)  # `signal_warnings` says it of the run
        return cfc(signal, float(times[1] - times[0]) * unit, cls)


def _impulses(
    model: Model, name: str, history: dict[str, FloatArray], signal: FloatArray
) -> FloatArray:
    """(n - 1, k) integrals of a signal over each step.

    Of an acceleration the change of velocity, which is exact; where that is not measured, and of
    forces, by the trapezoidal rule: for the centre of a free body the same.
    """
    velocities = [f"{name}.v{axis}" for axis in "xyz"]
    along = {sensor.name for sensor in model.point_sensors if sensor.axes == "world"}
    if name in along and all(column in history for column in velocities):
        return np.diff(np.stack([history[column] for column in velocities], axis=1), axis=0)
    return trapezoids(history["time"], signal)


def sensor_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, dict[str, Any]]:
    """What the sensors say of the whole run: extremes and criteria, by name of the sensor."""
    return {
        sensor.name: {
            "body": sensor.body,
            "filter": sensor.filter,
            "criteria": _criteria(model, sensor, history),
            **coded(sensor),
        }
        for sensor in model.point_sensors
    } | relative_summary(model)


def relative_summary(model: Model) -> dict[str, dict[str, Any]]:
    """Of sensors between two bodies: which."""
    return {
        one.name: {"body": " – ".join(one.between), "filter": None, "criteria": {}} | coded(one)
        for one in model.relative
    }


def coded(sensor: Sensor | RelativeSensor) -> dict[str, str]:
    """Its code in files of ISO-MME, where it was given one."""
    return {} if sensor.code is None else {"code": sensor.code}


def _criteria(
    model: Model, sensor: Sensor, history: dict[str, FloatArray]
) -> dict[str, dict[str, Any]]:
    """Each criterion with its value and band, and when it holds, in the time unit of the case."""
    if not sensor.criteria or f"{sensor.name}.a" not in history or len(history["time"]) < 2:
        return {}
    if sensor.filter is None:
        times, acceleration = history["time"], history[f"{sensor.name}.a"]
    elif too_coarse(model, sensor.filter, history):
        return {}
    else:
        times, filtered = _smooth(model, sensor.name, history)
        acceleration = np.array([length(row) for row in filtered])
    length_unit, _, time_unit = model.units
    a = acceleration / acceleration_factor("g", length_unit, time_unit)
    unit = base_factor(time_unit, "time")
    t = times * unit
    if not np.isfinite(a).all():
        return {}
    found: dict[str, dict[str, Any]] = {}
    for name in sensor.criteria:
        if name == "3ms":
            if t[-1] - t[0] < 0.003:
                continue
            value, start, end = clip(a, t, 0.003)[:3]
        else:
            value, start, end = hic(a, t, _WINDOWS[name])
            value = hicd(value) if name == "HICd" else value
        found[name] = {"value": value, "start": start / unit, "end": end / unit}
        if name in sensor.bands:
            found[name]["band"] = sensor.bands[name].of(value)
    return found


def signal_warnings(model: Model, history: dict[str, FloatArray]) -> list[str]:
    """Filters that the steps of the run are too long for, or the run too short."""
    told = []
    for name, (cls, _) in _filtered(model).items():
        if too_coarse(model, cls, history):
            told.append(
                f"{name}: the steps are too long for {cls}, which needs "
                f"{LEAST_RATE} samples a second for each Hz of its class; nothing is filtered and "
                'its criteria are left out. Take smaller steps, or step = "auto" with a shorter '
                "largest one"
            )
            continue
        kept = memory(int(cls.removeprefix("CFC"))) / base_factor(model.units[2], "time")
        lasts = float(np.ptp(history["time"]))
        if lasts < kept:
            told.append(
                f"{name}: the run lasts {lasts:.4g}, less than the memory of {cls}, {kept:.4g}: "
                "what is filtered may be off by a fifth of its size at the ends, and its criteria "
                "with it"
            )
    return told
