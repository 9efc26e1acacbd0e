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
from contiga.simulation.sensor import Sensor

FINE = 2 * LEAST_RATE
"""Samples a second for each Hz of a filter's class, where steps are of several lengths."""
MOST = 2_000_000
"""Samples a signal is brought to at most."""
_EQUAL = 1e-6
_WINDOWS = {"HIC15": 0.015, "HIC36": 0.036, "HICd": 0.036}


def filtered_columns(model: Model, history: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Filtered accelerations of sensors that ask for them, with their resultants, and filtered
    forces of springs, by column."""
    columns: dict[str, FloatArray] = {}
    for name, (cls, raw) in _filtered(model).items():
        if too_coarse(model, cls, history):
            continue
        smooth = _smooth(model, cls, history["time"], [history[f"{name}.{c}"] for c in raw])
        columns |= {f"{name}.filtered_{c}": row for c, row in zip(raw, smooth, strict=True)}
        if len(raw) > 1:
            columns[f"{name}.filtered_a"] = np.array([length(row) for row in smooth.T])
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


def _smooth(model: Model, cls: str, times: FloatArray, columns: list[FloatArray]) -> FloatArray:
    """(k, n) columns, filtered."""
    grid, signal = _even(model, cls, times, np.stack(columns, axis=1))
    dt = float(grid[1] - grid[0]) * base_factor(model.units[2], "time")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContigaWarning)  # `signal_warnings` says it of the run
        smooth = cfc(signal, dt, cls)
    return np.stack([np.interp(times, grid, channel) for channel in smooth.T])


def _even(
    model: Model, cls: str, times: FloatArray, signal: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Times one step apart (m,) and the signal there (m, k)."""
    steps = np.diff(times)
    if np.ptp(steps) <= _EQUAL * steps.max():
        return times, signal
    unit = base_factor(model.units[2], "time")
    step = 1.0 / (FINE * int(cls.removeprefix("CFC"))) / unit
    step = min(step, float(np.median(steps)))
    count = min(int(np.ceil((times[-1] - times[0]) / step)), MOST)
    grid = np.linspace(times[0], times[-1], count + 1)
    return grid, np.stack([np.interp(grid, times, channel) for channel in signal.T], axis=1)


def sensor_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, dict[str, Any]]:
    """What the sensors say of the whole run: extremes and criteria, by name of the sensor."""
    return {
        sensor.name: {
            "body": sensor.body,
            "filter": sensor.filter,
            "criteria": _criteria(model, sensor, history),
        }
        for sensor in model.point_sensors
    } | relative_summary(model)


def relative_summary(model: Model) -> dict[str, dict[str, Any]]:
    """Of sensors between two bodies: which."""
    return {
        one.name: {"body": " – ".join(one.between), "filter": None, "criteria": {}}
        for one in model.relative
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
