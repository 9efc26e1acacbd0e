"""How free bodies move and what sensors measure: figures over time, and tables of extremes."""

from __future__ import annotations

from html import escape
from typing import Any, NamedTuple

import numpy as np

from contiga.records import FloatArray
from contiga.report.lines import add_line, finish, largest, vector_figure, with_unit
from contiga.report.run_folder import Columns, Run
from contiga.report.style import INK, LINES, MUTED, number

_STILL = 1e-9
"""Radians below which a body has not turned: rounding."""


class Quantity(NamedTuple):
    """A vector over time as it is shown."""

    label: str
    unit: str
    components: dict[str, FloatArray]
    """(n,) along x, y and z."""

    @property
    def whole(self) -> FloatArray:
        """(n,) magnitudes."""
        return np.asarray(np.sqrt(sum(c**2 for c in self.components.values())))


def body_quantities(run: Run, body: str) -> list[Quantity]:
    """Displacement of the centre, velocity, acceleration and spin of a free body; none of zeros."""
    columns, units = run.bodies[body], run.units
    way = {axis: columns[axis] - columns[axis][0] for axis in "xyz" if axis in columns}
    found = [
        Quantity("Displacement of the centre", units.length, way),
        Quantity("Velocity of the centre", units.velocity, _along(columns, "v{}")),
        _acceleration("Acceleration of the centre", run, _along(columns, "a{}")),
    ]
    spin = _along(columns, "w{}")
    if max(map(largest, spin.values()), default=0.0) * np.ptp(run.times) > _STILL:
        found.append(Quantity("Spin", units.spin, spin))
    return [q for q in found if any(largest(c) > 0.0 for c in q.components.values())]


def sensor_quantities(run: Run, sensor: str) -> list[Quantity]:
    """What a sensor measures beside its acceleration; none of zeros."""
    columns, units = run.sensors[sensor], run.units
    found = [
        Quantity("Velocity", units.velocity, _along(columns, "v{}")),
        Quantity("Displacement", units.length, _along(columns, "{}")),
        Quantity("Force", units.force, _along(columns, "f{}")),
        Quantity("Moment", units.moment, _along(columns, "m{}")),
    ]
    return [q for q in found if any(largest(c) > 0.0 for c in q.components.values())]


def body_figures(run: Run, body: str, peak_time: float | None) -> list[Any]:
    """Of each quantity its components and their resultant."""
    return _figures(run, body_quantities(run, body), peak_time)


def sensor_figures(run: Run, sensor: str, peak_time: float | None) -> list[Any]:
    """Acceleration, raw and filtered, with what the criteria found in it; and the rest."""
    first = _acceleration_figure(run, sensor, peak_time)
    return [] if first is None else [first, *_figures(run, sensor_quantities(run, sensor), peak_time)]


def _figures(run: Run, quantities: list[Quantity], peak_time: float | None) -> list[Any]:
    return [vector_figure(run, peak_time, q.components, (q.label, q.unit)) for q in quantities]


def _along(columns: Columns, name: str) -> dict[str, FloatArray]:
    return {axis: columns[name.format(axis)] for axis in "xyz" if name.format(axis) in columns}


def _acceleration(label: str, run: Run, of: dict[str, FloatArray]) -> Quantity:
    shown = {axis: run.units.accelerations(values) for axis, values in of.items()}
    unit = run.units.accelerations(np.zeros(0))[1]
    return Quantity(label, unit, {axis: values for axis, (values, _) in shown.items()})
