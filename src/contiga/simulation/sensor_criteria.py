"""Evaluate injury criteria of a whole run, each on the signal that its source asks for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

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
from contiga.simulation.sensor import ALL_CRITERIA, RelativeSensor, Sensor
from contiga.simulation.sensors import on_axes
from contiga.simulation.signals import smooth, too_coarse
from contiga.simulation.slave_sensor import slave_of
from contiga.simulation.springs import first_time

History = dict[str, FloatArray]
Found = dict[str, Any]
"""`value`, and `start` and `end` of when it holds, seconds."""
_HELD = 0.003


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
        for name in sensor.criteria:
            cls = ALL_CRITERIA[name].filter
            if cls is None or too_coarse(model, cls, history):
                continue
            columns = [f"{sensor.name}.{column}" for column in ALL_CRITERIA[name].columns]
            if not all(np.isfinite(history[column]).all() for column in columns):
                continue
            grid, values = smooth(model, columns, cls, history)
            one = OF_SIGNALS[name](_signal(model, sensor, grid, values))
            if one is not None:
                found[name] = one
        unit, criteria = base_factor(model.units[2], "time"), summary[sensor.name]["criteria"]
        for name in sensor.criteria:
            if name not in found:
                continue
            one = found[name]
            criteria[name] = {**one, "start": one["start"] / unit, "end": one["end"] / unit}
            if ALL_CRITERIA[name].unit:
                criteria[name]["unit"] = ALL_CRITERIA[name].unit
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
    asked = [name for name in sensor.criteria if name in OF_ACCELERATION]
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
        one = OF_ACCELERATION[name](a, t)
        if one is not None:
            yield name, one


def _hic(a: FloatArray, t: FloatArray, longest: float) -> Found:
    value, start, end = hic(a, t, longest)
    return {"value": value, "start": start, "end": end}


def _hicd(a: FloatArray, t: FloatArray) -> Found:
    found = _hic(a, t, 0.036)
    return {**found, "value": hicd(found["value"])}


def _clip(a: FloatArray, t: FloatArray, cumulative: bool) -> Found | None:
    """Return the 3 ms value; None of a run that is shorter than that."""
    if t[-1] - t[0] < _HELD:
        return None
    value, start, end = clip(a, t, _HELD, cumulative=cumulative)[:3]
    return {"value": value, "start": start, "end": end}


OF_ACCELERATION: dict[str, Callable[[FloatArray, FloatArray], Found | None]] = {
    "HIC15": partial(_hic, longest=0.015),
    "HIC36": partial(_hic, longest=0.036),
    "HICd": _hicd,
    "3ms": partial(_clip, cumulative=False),
    "chest3ms": partial(_clip, cumulative=True),
}
"""Criteria of the resultant acceleration (n,), g, at times (n,), s."""


class Signal(NamedTuple):
    """The signal of a criterion over a run, filtered as its source asks."""

    model: Model
    sensor: Sensor | RelativeSensor
    times: FloatArray
    """(m,) even times, s."""
    values: FloatArray
    """(m, k) the columns of the criterion, in units of the case."""
    metre: float
    """The length unit of the case, m; `kilogram` and `second` are its mass and time units."""
    kilogram: float
    second: float

    @property
    def newton(self) -> float:
        """The force unit of the case, N."""
        return self.kilogram * self.metre / self.second**2

    @property
    def pair(self) -> RelativeSensor:
        """The sensor, of a criterion of a `RelativeSensor`."""
        assert isinstance(self.sensor, RelativeSensor)
        return self.sensor


def _signal(
    model: Model, sensor: Sensor | RelativeSensor, grid: FloatArray, values: FloatArray
) -> Signal:
    """Return columns (m, k) at even times (m,) of the case as a signal."""
    metre, kilogram, second = (
        base_factor(unit, kind)
        for unit, kind in zip(model.units, ("length", "mass", "time"), strict=True)
    )
    return Signal(model, sensor, grid * second, values, metre, kilogram, second)


def _bric(signal: Signal) -> Found:
    w = signal.values / signal.second
    time = signal.times[int(np.argmax((np.abs(w) / CRITICAL).max(axis=1)))]
    return {"value": bric(w).value, "start": time, "end": time}


def _vc(signal: Signal) -> Found | None:
    """Return the viscous criterion; None of a run of fewer samples than it takes."""
    if len(signal.times) < LEAST:
        return None
    dummy, distance, t = DUMMIES[signal.pair.dummy], signal.values[:, 0], signal.times
    pressed = (distance[0] - distance) * signal.metre
    value, after = vc(pressed, float(t[1] - t[0]), scale=dummy.chest_scale, depth=dummy.chest_depth)
    return {"value": value, "start": t[0] + after, "end": t[0] + after}


def _nij(signal: Signal) -> Found:
    limits, (force, moment) = DUMMIES[signal.pair.dummy].neck, signal.values.T
    assert limits is not None
    value, k, mode = nij(force * signal.newton, moment * signal.newton * signal.metre, limits)
    return {"value": value, "start": signal.times[k], "end": signal.times[k], "mode": mode}


def _femur(signal: Signal) -> Found:
    along = signal.values @ _first_axis(signal.model, signal.pair)
    force, time = femur_force(along * signal.newton, signal.times), signal.times[np.argmin(along)]
    return {
        "value": force.ratio,
        "start": time,
        "end": time,
        "peak": force.peak,
        "held": force.held,
    }


OF_SIGNALS: dict[str, Callable[[Signal], Found | None]] = {
    "BrIC": _bric,
    "VC": _vc,
    "Nij": _nij,
    "femur": _femur,
}
"""Criteria with a filter of their own."""


def _first_axis(model: Model, sensor: RelativeSensor) -> FloatArray:
    """Return the direction (3,) from the first point to the second at the start, sensor axes."""
    origin = model.origins[model.mechanism.root_of(sensor.between[0])]
    assert sensor.at is not None
    way = on_axes(sensor, origin, origin, sensor.at[1] - sensor.at[0])
    return np.asarray(way / length(way))
