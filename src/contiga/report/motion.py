"""Motion of free bodies and measurements of sensors: figures over time, and tables of extremes."""

from __future__ import annotations

from html import escape
from typing import Any, NamedTuple

import numpy as np

from contiga.io.units import with_unit
from contiga.records import FloatArray
from contiga.report.figure import Figure
from contiga.report.html_tables import named_row, named_table
from contiga.report.lines import add_line, finish, largest, vector_figure
from contiga.report.run_folder import Columns, Run
from contiga.report.style import INK, LINES, PAPER, number, span_of

_STILL = 1e-9
"""Rotation, rad, below which a body has not turned: rounding."""


class Quantity(NamedTuple):
    """A vector over time in the units of the page."""

    label: str
    unit: str
    components: dict[str, FloatArray]
    """(n,) components along x, y and z."""

    @property
    def whole(self) -> FloatArray:
        """The magnitudes (n,)."""
        return np.asarray(np.sqrt(sum(c**2 for c in self.components.values())))


def body_quantities(run: Run, body: str) -> list[Quantity]:
    """Return displacement of the centre, velocity, acceleration and spin of a body, if not zero."""
    columns, units = run.bodies[body], run.units
    way = {axis: columns[axis] - columns[axis][0] for axis in "xyz" if axis in columns}
    quantities = [
        Quantity("Displacement of the centre", units.length, way),
        Quantity("Velocity of the centre", units.velocity, _along(columns, "v{}")),
        _acceleration("Acceleration of the centre", run, _along(columns, "a{}")),
    ]
    spin = _along(columns, "w{}")
    if max(map(largest, spin.values()), default=0.0) * np.ptp(run.times) > _STILL:
        quantities.append(Quantity("Spin", units.spin, spin))
    return [q for q in quantities if any(largest(c) > 0.0 for c in q.components.values())]


def sensor_quantities(run: Run, sensor: str) -> list[Quantity]:
    """Return the measurements of a sensor except its acceleration.

    Zeros are left out, and quantities that its body has already.
    """
    columns, units = run.sensors[sensor], run.units
    quantities = [
        Quantity("Velocity", units.velocity, _along(columns, "v{}")),
        Quantity("Displacement", units.length, _along(columns, "{}")),
        Quantity("Force", units.force, _along(columns, "f{}")),
        Quantity("Moment", units.moment, _along(columns, "m{}")),
        Quantity("Spin", units.spin, _along(columns, "w{}")),
    ]
    body = _summary_of(run, sensor).get("body")
    known = body_quantities(run, body) if body in run.bodies else []
    return [
        q
        for q in quantities
        if any(largest(c) > 0.0 for c in q.components.values())
        and not any(_same(q, other) for other in known)
    ]


def _same(one: Quantity, other: Quantity) -> bool:
    """Return whether two quantities are equal, up to rounding."""
    if one.unit != other.unit or set(one.components) != set(other.components):
        return False
    floor = 1e-9 * largest(other.whole)
    return all(
        np.allclose(c, other.components[axis], rtol=0.0, atol=floor)
        for axis, c in one.components.items()
    )


def body_figures(run: Run, body: str, peak_time: float | None) -> list[Figure]:
    """Return, for each quantity, a figure of its components and their resultant."""
    return _figures(run, body_quantities(run, body), peak_time)


def sensor_figures(run: Run, sensor: str, peak_time: float | None) -> list[Figure]:
    """Return figures of acceleration, raw and filtered, with its criteria, and of the rest."""
    first = _acceleration_figure(run, sensor, peak_time)
    others = _figures(run, sensor_quantities(run, sensor), peak_time)
    measures = ("distance", "Distance", run.units.length), ("angle", "Turn", "rad")
    drawn = [_scalar_figure(run, sensor, what, peak_time) for what in measures]
    scalars = [figure for figure in drawn if figure is not None]
    return [*([] if first is None else [first]), *scalars, *others]


def _scalar_figure(
    run: Run, sensor: str, what: tuple[str, str, str], peak_time: float | None
) -> Figure | None:
    """Return one line of a sensor between two bodies; None if it has none, or all is zero."""
    column, label, unit = what
    values = run.sensors[sensor].get(column)
    if values is None or not largest(values) > 0.0:
        return None
    figure = Figure()
    add_line(figure, run.times, values, label, unit, color=LINES[0], width=2.2)
    finish(figure, run, with_unit(label, unit), peak_time)
    figure.layout["showlegend"] = False
    return figure


def _figures(run: Run, quantities: list[Quantity], peak_time: float | None) -> list[Figure]:
    drawn = (vector_figure(run, peak_time, q.components, (q.label, q.unit)) for q in quantities)
    return [figure for figure in drawn if figure is not None]


def _along(columns: Columns, name: str) -> dict[str, FloatArray]:
    return {axis: columns[name.format(axis)] for axis in "xyz" if name.format(axis) in columns}


def _acceleration(label: str, run: Run, of: dict[str, FloatArray]) -> Quantity:
    shown = {axis: run.units.accelerations(values) for axis, values in of.items()}
    unit = run.units.accelerations(np.zeros(0))[1]
    return Quantity(label, unit, {axis: values for axis, (values, _) in shown.items()})


def _acceleration_figure(run: Run, sensor: str, peak_time: float | None) -> Figure | None:
    """Return the resultant acceleration and its criteria; thin under a filtered one."""
    columns = run.sensors[sensor]
    if largest(columns.get("a")) == 0.0:
        return None
    figure = Figure()
    raw, unit = run.units.accelerations(columns["a"])
    if "filtered_a" in columns:
        name = str(_summary_of(run, sensor).get("filter") or "filtered")
        add_line(figure, run.times, raw, "as computed", unit, color="#b4bac2", width=1.0)
        smooth = run.units.accelerations(columns["filtered_a"])[0]
        add_line(figure, run.times, smooth, name, unit, color=LINES[0], width=2.2)
    else:
        add_line(figure, run.times, raw, "resultant", unit, color=LINES[0], width=2.2)
    finish(figure, run, with_unit("Acceleration, resultant", unit), peak_time)
    _mark_criteria(figure, _summary_of(run, sensor).get("criteria") or {})
    figure.layout["showlegend"] = len(figure.data) > 1
    return figure


def _summary_of(run: Run, sensor: str) -> dict[str, Any]:
    return dict(run.summary_part("sensors").get(sensor) or {})


def _mark_criteria(figure: Figure, criteria: dict[str, dict[str, float]]) -> None:
    """Mark the window of the head injury criterion, and the level that is held for 3 ms."""
    window = next((name for name in ("HIC15", "HIC36", "HICd") if name in criteria), None)
    if window is not None:
        result = criteria[window]
        shade = {"fillcolor": "#b07d1e", "opacity": 0.14, "line": {"width": 0}}
        _over(figure, result, {"type": "rect", "y0": 0, "y1": 1, "yref": "y domain", **shade})
        middle = (result["start"] + result["end"]) / 2.0
        _note(figure, middle, 0.0, f"{window} = {number(result['value'])}")
    if "3ms" in criteria:
        held = criteria["3ms"]
        level, line = held["value"], {"color": INK, "width": 1.8}
        _over(figure, held, {"type": "line", "y0": level, "y1": level, "line": line})
        _note(figure, held["end"], held["value"], f"3 ms: {number(held['value'])} g")


def _over(figure: Figure, criterion: dict[str, float], shape: dict[str, Any]) -> None:
    """Add a shape over the time at which a criterion holds."""
    figure.layout["shapes"].append({"x0": criterion["start"], "x1": criterion["end"], **shape})


def _note(figure: Figure, x: float, y: float, text: str) -> None:
    note = {
        "x": x,
        "y": y,
        "text": text,
        "showarrow": False,
        "yanchor": "bottom",
        "xanchor": "center" if y == 0.0 else "left",
        "font": {"size": 12, "color": INK},
        "bgcolor": f"{PAPER}b3",
    }
    figure.layout.setdefault("annotations", []).append(note)


def extremes_table(run: Run) -> str:
    """Return the largest magnitudes of quantities of free bodies, with times and end values."""
    rows = []
    for body in run.bodies:
        for quantity in body_quantities(run, body):
            whole = quantity.whole
            at = int(np.nanargmax(whole))
            cells = [
                f"{number(float(whole[at]))} {escape(quantity.unit)}",
                f"{number(float(run.times[at]))} {escape(run.units.time)}",
                f"{number(float(whole[-1]))} {escape(quantity.unit)}",
            ]
            rows.append(named_row(body, quantity.label, cells))
    return named_table(("Body", "Quantity", "Largest", "at t =", "At the end"), rows)


def criteria_table(run: Run) -> str:
    """Return the criteria of all sensors, with their times."""
    rows = []
    for sensor in run.sensors:
        facts = _summary_of(run, sensor)
        name = " · ".join(str(t) for t in (sensor, facts.get("body"), facts.get("filter")) if t)
        for criterion, result in (facts.get("criteria") or {}).items():
            unit = f" {result.get('unit', '')}".rstrip()
            span = f"{span_of(result)} {escape(run.units.time)}"
            band = f" ({escape(str(result['band']))})" if "band" in result else ""
            rows.append(named_row(name, criterion, [number(result["value"]) + unit + band, span]))
    return named_table(("Sensor", "Criterion", "Value", "Window"), rows)
