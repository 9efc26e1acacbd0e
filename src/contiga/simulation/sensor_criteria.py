"""Evaluate injury criteria of a whole run, each on the signal that its source specifies."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from contiga.arrays.layout import checked_choice
from contiga.arrays.ordered import length
from contiga.criteria.brain import CRITICAL_VELOCITIES, bric
from contiga.criteria.chest import MIN_SAMPLES, vc
from contiga.criteria.dummies import DUMMIES
from contiga.criteria.femur import femur_force
from contiga.criteria.filters import NAMES as FILTERS
from contiga.criteria.head_injury import hic, hicd
from contiga.criteria.held_level import clip
from contiga.criteria.neck import nij
from contiga.errors import InputError
from contiga.io.units import acceleration_factor, base_factor
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.sensor import ALL_CRITERIA, Criterion, RelativeSensor, Sensor
from contiga.simulation.sensors import on_axes
from contiga.simulation.signals import smooth, too_coarse
from contiga.simulation.slave_sensor import slave_of
from contiga.simulation.springs import first_time

History = dict[str, FloatArray]
Value = dict[str, Any]
"""`value` of a criterion, with `start` and `end` of its time window, seconds."""
_CLIP_TIME = 0.003


def sensor_summary(model: Model, history: History) -> dict[str, dict[str, Any]]:
    """Return body, filter and criteria of all sensors over the whole run, by name of the sensor.

    Criteria have values, bands, and time windows in the time unit of the case; code and time of
    firing are added for sensors with a code or trigger. A criterion is left out if steps are too
    long for its filter, its signal is not finite, or the run is too short for it.
    """
    summary = sensors_without_criteria(model, history)
    sensors: list[Sensor | RelativeSensor] = [*model.point_sensors, *model.relative]
    if len(history["time"]) < 2 or not any(sensor.criteria for sensor in sensors):
        return summary
    units = tuple(map(base_factor, model.units, ("length", "mass", "time")))
    for sensor in sensors:
        if not sensor.criteria:
            continue
        results: dict[str, Value] = {}
        if isinstance(sensor, Sensor):
            results.update(_acceleration_criteria(model, sensor, history))
        for name in sensor.criteria:
            cls = ALL_CRITERIA[name].filter
            if cls is None or too_coarse(model, cls, history):
                continue
            columns = [f"{sensor.name}.{column}" for column in ALL_CRITERIA[name].columns]
            if not all(np.isfinite(history[column]).all() for column in columns):
                continue
            grid, values = smooth(model, columns, cls, history)
            result = OF_SIGNALS[name](Signal(model, sensor, grid * units[2], values, *units))
            if result is not None:
                results[name] = result
        unit, criteria = units[2], summary[sensor.name]["criteria"]
        for name in sensor.criteria:
            if name not in results:
                continue
            window = {key: results[name][key] / unit for key in ("start", "end")}
            criteria[name] = {**results[name], **window}
            if ALL_CRITERIA[name].unit:
                criteria[name]["unit"] = ALL_CRITERIA[name].unit
            if name in sensor.bands:
                criteria[name]["band"] = sensor.bands[name].of(results[name]["value"])
    return summary


def sensors_without_criteria(model: Model, history: History) -> dict[str, dict[str, Any]]:
    """Return body, filter, code and empty `criteria` of all sensors, by name, for the summary.

    A sensor with a trigger has `fired`: the time of the first row in which it has fired, or None.
    """
    summary: dict[str, dict[str, Any]] = {
        sensor.name: {"body": sensor.body, "filter": sensor.filter}
        for sensor in model.point_sensors
    }
    for pair in model.relative:
        summary[pair.name] = {"body": " – ".join(pair.between), "filter": None}
    for on_slave in model.slave_sensors:
        summary[on_slave.name] = {"body": slave_of(on_slave), "filter": None}
    for any_sensor in model.sensors:
        summary[any_sensor.name]["criteria"] = {}
        if any_sensor.code is not None:
            summary[any_sensor.name]["code"] = any_sensor.code
    for trigger in model.triggered:
        summary[trigger.name]["fired"] = first_time(history, f"{trigger.name}.fired")
    return summary


def _acceleration_criteria(
    model: Model, sensor: Sensor, history: History
) -> Iterator[tuple[str, Value]]:
    """Yield name and value of criteria of the resultant acceleration, filtered if the sensor is.

    Nothing is yielded if the steps are too long for the filter, or the acceleration is not finite;
    criteria for which the run is too short are left out.
    """
    names = [name for name in sensor.criteria if name in OF_ACCELERATION]
    if not names or f"{sensor.name}.a" not in history:
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
    for name in names:
        value = OF_ACCELERATION[name](a, t)
        if value is not None:
            yield name, value


def _hic(a: FloatArray, t: FloatArray, longest: float) -> Value:
    value, start, end = hic(a, t, longest)
    return {"value": value, "start": start, "end": end}


def _hicd(a: FloatArray, t: FloatArray) -> Value:
    result = _hic(a, t, 0.036)
    return {**result, "value": hicd(result["value"])}


def _clip(a: FloatArray, t: FloatArray, cumulative: bool) -> Value | None:
    """Return the 3 ms value with start and end of its window; None for a run shorter than 3 ms."""
    if t[-1] - t[0] < _CLIP_TIME:
        return None
    value, start, end = clip(a, t, _CLIP_TIME, cumulative=cumulative)[:3]
    return {"value": value, "start": start, "end": end}


OF_ACCELERATION: dict[str, Callable[[FloatArray, FloatArray], Value | None]] = {
    "HIC15": partial(_hic, longest=0.015),
    "HIC36": partial(_hic, longest=0.036),
    "HICd": _hicd,
    "3ms": partial(_clip, cumulative=False),
    "chest3ms": partial(_clip, cumulative=True),
}
"""Criteria of the resultant acceleration (n,), g, at times (n,), s."""


class Signal(NamedTuple):
    """The signal of a criterion over a run, filtered as its source specifies."""

    model: Model
    sensor: Sensor | RelativeSensor
    times: FloatArray
    """(m,) even times, s."""
    values: FloatArray
    """(m, k) the columns of the criterion, in units of the case."""
    metre: float
    """The length unit of the case, m."""
    kilogram: float
    """The mass unit of the case, kg."""
    second: float
    """The time unit of the case, s."""

    @property
    def newton(self) -> float:
        """The force unit of the case, in N."""
        return self.kilogram * self.metre / self.second**2

    @property
    def pair(self) -> RelativeSensor:
        """The sensor, for a criterion of a `RelativeSensor`."""
        assert isinstance(self.sensor, RelativeSensor)
        return self.sensor


def _bric(signal: Signal) -> Value:
    """Return BrIC, with the time at which a component of the spin is largest over its limit."""
    w = signal.values / signal.second
    time = signal.times[int(np.argmax((np.abs(w) / CRITICAL_VELOCITIES).max(axis=1)))]
    return {"value": bric(w).value, "start": time, "end": time}


def _vc(signal: Signal) -> Value | None:
    """Return the viscous criterion of the distance, with its time as start and end.

    Returns None for a signal with fewer than `MIN_SAMPLES` samples.
    """
    if len(signal.times) < MIN_SAMPLES:
        return None
    dummy, distance, t = DUMMIES[signal.pair.dummy], signal.values[:, 0], signal.times
    compression = (distance[0] - distance) * signal.metre
    value, delay = vc(
        compression, float(t[1] - t[0]), scale=dummy.chest_scale, depth=dummy.chest_depth
    )
    return {"value": value, "start": t[0] + delay, "end": t[0] + delay}


def _nij(signal: Signal) -> Value:
    """Return the largest Nij, its time, and its mode of loading."""
    limits, (force, moment) = DUMMIES[signal.pair.dummy].neck, signal.values.T
    assert limits is not None
    value, k, mode = nij(force * signal.newton, moment * signal.newton * signal.metre, limits)
    return {"value": value, "start": signal.times[k], "end": signal.times[k], "mode": mode}


def _femur(signal: Signal) -> Value:
    """Return the femur criterion of the force along the line of the two points.

    `value` is the ratio to the limit, `peak` and `held` are peak and 10 ms level of the force in
    compression; start and end are the time of the peak.
    """
    sensor = signal.pair
    assert sensor.at is not None
    origin = signal.model.origins[signal.model.mechanism.root_of(sensor.between[0])]
    axis = on_axes(sensor, origin, origin, sensor.at[1] - sensor.at[0])
    axial = signal.values @ np.asarray(axis / length(axis))
    force, time = femur_force(axial * signal.newton, signal.times), signal.times[np.argmin(axial)]
    return {
        "value": force.ratio,
        "start": time,
        "end": time,
        "peak": force.peak,
        "held": force.held,
    }


OF_SIGNALS: dict[str, Callable[[Signal], Value | None]] = {
    "BrIC": _bric,
    "VC": _vc,
    "Nij": _nij,
    "femur": _femur,
}
"""Criteria with a filter of their own."""


def check_criteria(
    rows: Mapping[str, Criterion], of_acceleration: Container[str], of_signals: Container[str]
) -> None:
    """Raise `InputError` for a criterion that a run would leave out without a word.

    A row with a filter has its function in `of_signals`, one without in `of_acceleration`; nothing
    else is evaluated.
    """
    for name, row in rows.items():
        if row.filter is not None:
            checked_choice(f"criterion {name!r}: filter", row.filter, FILTERS)
        table = "OF_ACCELERATION" if row.filter is None else "OF_SIGNALS"
        if name not in (of_acceleration if row.filter is None else of_signals):
            raise InputError(
                "a criterion with this filter has no function that evaluates it",
                where=f"criterion {name!r}: filter",
                found=row.filter,
                allowed=f"a function in {table}",
            )


check_criteria(ALL_CRITERIA, OF_ACCELERATION, OF_SIGNALS)
