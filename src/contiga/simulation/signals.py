"""Filter signals after a run: accelerations of sensors and forces of springs."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence

import numpy as np

from contiga.arrays.ordered import length
from contiga.criteria.filters import MIN_RATE, cfc, settling_time
from contiga.errors import ContigaWarning
from contiga.io.units import base_factor
from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.resampling import FINE, even_times, means, trapezoids
from contiga.simulation.sensor import ALL_CRITERIA

_EQUAL_TOL = 1e-6


def filtered_columns(model: Model, history: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """Return columns of filtered accelerations of sensors, with resultants, and of spring forces.

    They are at the times of the history. Filters that need shorter steps are left out.
    """
    columns: dict[str, FloatArray] = {}
    times = history["time"]
    for name, (cls, raw) in _filter_requests(model).items():
        if too_coarse(model, cls, history):
            continue
        grid, filtered = smooth(model, [f"{name}.{c}" for c in raw], cls, history)
        if grid is not times:
            filtered = means(times, grid, filtered, trapezoids(grid, filtered))
        columns |= {f"{name}.filtered_{c}": filtered[:, i] for i, c in enumerate(raw)}
        if len(raw) > 1:
            columns[f"{name}.filtered_a"] = np.array([length(row) for row in filtered])
    return columns


def _filter_requests(model: Model) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return the filter class and the columns to filter of each sensor and spring with a filter."""
    accelerations = ("ax", "ay", "az")
    sensors = {s.name: (s.filter, accelerations) for s in model.point_sensors if s.filter}
    springs = {name: (s.filter, ("force",)) for name, s in model.springs.items() if s.filter}
    return {**sensors, **springs}


def _filter_classes(model: Model) -> dict[str, list[str]]:
    """Return the filter classes, own and of criteria, of the sensors and springs that have any."""
    classes = {name: [cls] for name, (cls, _) in _filter_requests(model).items()}
    for sensor in model.sensors:
        filters = [ALL_CRITERIA[criterion].filter for criterion in sensor.criteria]
        of_criteria = [cls for cls in filters if cls is not None]
        if of_criteria:
            classes[sensor.name] = list(
                dict.fromkeys([*classes.get(sensor.name, []), *of_criteria])
            )
    return classes


def too_coarse(model: Model, cls: str, history: Mapping[str, FloatArray]) -> bool:
    """Return whether the longest step is too long for a filter class, or there is no step."""
    times = history["time"]
    return len(times) < 2 or float(np.diff(times).max()) > (1.0 + _EQUAL_TOL) * _longest_sample_of(
        model, cls
    )


def longest_sample(model: Model) -> float:
    """Return the longest step that all filters allow; infinite without any."""
    all_classes = (cls for classes in _filter_classes(model).values() for cls in classes)
    return min((_longest_sample_of(model, cls) for cls in all_classes), default=np.inf)


def _longest_sample_of(model: Model, cls: str) -> float:
    hertz = MIN_RATE * int(cls.removeprefix("CFC"))
    return 1.0 / (hertz * base_factor(model.units[2], "time"))


def smooth(
    model: Model, columns: Sequence[str], cls: str, history: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return even times (m,) and columns of a history filtered at these times (m, k).

    The times are those of the history if its steps are equal, otherwise it is resampled so that
    integrals over steps are conserved.
    """
    times, unit = history["time"], base_factor(model.units[2], "time")
    signal = np.stack([history[column] for column in columns], axis=1)
    grid = even_times(times, 1.0 / (FINE * int(cls.removeprefix("CFC"))) / unit)
    if grid is times:
        return times, _filtered_evenly(times, signal, unit, cls)
    # Integrals over each step (n − 1, k): for an acceleration the exact change of velocity, if that
    # is measured; otherwise by the trapezoidal rule, which is the same for the centre of a body.
    in_world_axes = {f"{sensor.name}.a" for sensor in model.point_sensors if not sensor.turns}
    velocities = [f"{column[:-2]}v{column[-1]}" for column in columns]
    if {column[:-1] for column in columns} <= in_world_axes and all(
        v in history for v in velocities
    ):
        impulses = np.diff(np.stack([history[column] for column in velocities], axis=1), axis=0)
    else:
        impulses = trapezoids(times, signal)
    resampled = means(grid, times, signal, impulses)
    return grid, _filtered_evenly(grid, resampled, unit, cls)


def _filtered_evenly(times: FloatArray, signal: FloatArray, unit: float, cls: str) -> FloatArray:
    """Return a signal (n, k) at even times, filtered; the time unit is `unit` seconds."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContigaWarning)  # `signal_warnings` reports it
        return cfc(signal, float(times[1] - times[0]) * unit, cls)


def signal_warnings(model: Model, history: dict[str, FloatArray]) -> list[str]:
    """Return warnings about filters for which the steps are too long or the run too short."""
    texts = []
    for name, cls in ((n, cls) for n, classes in _filter_classes(model).items() for cls in classes):
        if too_coarse(model, cls, history):
            texts.append(
                f"{name}: the steps are too long for {cls}, which needs "
                f"{MIN_RATE} samples a second for each Hz of its class; nothing is filtered and "
                'its criteria are left out. Take smaller steps, or step = "auto" with a shorter '
                "largest one"
            )
            continue
        number, second = int(cls.removeprefix("CFC")), base_factor(model.units[2], "time")
        settling = settling_time(number) / second
        duration = float(np.ptp(history["time"]))
        if duration < settling:
            texts.append(
                f"{name}: the run lasts {duration:.4g} {model.units[2]}, less than the memory of "
                f"{cls}, {settling:.4g}: what is filtered may be off by a fifth of its size at "
                "the ends, and its criteria with it"
            )
    return texts
