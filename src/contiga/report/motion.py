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

_TURN_TOL = 1e-9
"""Rotation, rad, below which a body has not turned: rounding."""


class Quantity(NamedTuple):
    """A vector over time in the units of the page."""

    label: str
    unit: str
    components: dict[str, FloatArray]
    """(n,) components along x, y and z."""

    @property
    def magnitudes(self) -> FloatArray:
        """The magnitudes (n,)."""
        return np.asarray(np.sqrt(sum(c**2 for c in self.components.values())))

    def equals(self, other: Quantity) -> bool:
        """Return whether two quantities have one unit and axes, and differ by rounding at most.

        The bound is 1e-9 of the largest magnitude of `other`.
        """
        if self.unit != other.unit or set(self.components) != set(other.components):
            return False
        tol = 1e-9 * largest(other.magnitudes)
        return all(
            np.allclose(c, other.components[axis], rtol=0.0, atol=tol)
            for axis, c in self.components.items()
        )


def body_quantities(run: Run, body: str) -> list[Quantity]:
    """Return displacement of the centre, velocity, acceleration and spin of a body, if not zero.

    Accelerations are in g if the run names its units. Spins that turn the body by no more than
    1e-9 rad over the run, at their largest, are left out.
    """
    columns, units = run.bodies[body], run.units
    displacement = {axis: columns[axis] - columns[axis][0] for axis in "xyz" if axis in columns}
    acceleration = {
        axis: units.accelerations(values)[0] for axis, values in _vector(columns, "a{}").items()
    }
    quantities = [
        Quantity("Displacement of the centre", units.length, displacement),
        Quantity("Velocity of the centre", units.velocity, _vector(columns, "v{}")),
        Quantity("Acceleration of the centre", units.accelerations(np.zeros(0))[1], acceleration),
    ]
    spin = _vector(columns, "w{}")
    if max(map(largest, spin.values()), default=0.0) * np.ptp(run.times) > _TURN_TOL:
        quantities.append(Quantity("Spin", units.spin, spin))
    return [q for q in quantities if any(largest(c) > 0.0 for c in q.components.values())]


def sensor_quantities(run: Run, sensor: str) -> list[Quantity]:
    """Return velocity, displacement, force, moment and spin of a sensor.

    Zeros are left out, and quantities that are equal to one of its body.
    """
    columns, units = run.sensors[sensor], run.units
    quantities = [
        Quantity("Velocity", units.velocity, _vector(columns, "v{}")),
        Quantity("Displacement", units.length, _vector(columns, "{}")),
        Quantity("Force", units.force, _vector(columns, "f{}")),
        Quantity("Moment", units.moment, _vector(columns, "m{}")),
        Quantity("Spin", units.spin, _vector(columns, "w{}")),
    ]
    body = _summary_of(run, sensor).get("body")
    of_body = body_quantities(run, body) if body in run.bodies else []
    return [
        q
        for q in quantities
        if any(largest(c) > 0.0 for c in q.components.values())
        and not any(q.equals(other) for other in of_body)
    ]


def body_figures(run: Run, body: str, peak_time: float | None) -> list[Figure]:
    """Return, for each quantity, a figure of its components and their resultant."""
    return _figures(run, body_quantities(run, body), peak_time)


def sensor_figures(run: Run, sensor: str, peak_time: float | None) -> list[Figure]:
    """Return the figures of a sensor: acceleration, distance and turn, and its other quantities.

    The figure of the resultant acceleration marks its criteria; the raw signal is a thin line under
    a filtered one. Zeros have no figure.
    """
    columns = run.sensors[sensor]
    figures = []
    if largest(columns.get("a")) > 0.0:
        figure, facts = Figure(), _summary_of(run, sensor)
        acceleration, unit = run.units.accelerations(columns["a"])
        name = "resultant"
        if "filtered_a" in columns:
            add_line(
                figure, run.times, acceleration, "as computed", unit, color="#b4bac2", width=1.0
            )
            name = str(facts.get("filter") or "filtered")
            acceleration = run.units.accelerations(columns["filtered_a"])[0]
        add_line(figure, run.times, acceleration, name, unit, color=LINES[0], width=2.2)
        finish(figure, run, with_unit("Acceleration, resultant", unit), peak_time)
        _mark_criteria(figure, facts.get("criteria") or {})
        figure.layout["showlegend"] = len(figure.data) > 1
        figures.append(figure)
    # distance and turn of a sensor between two bodies
    measures = ("distance", "Distance", run.units.length), ("angle", "Turn", "rad")
    for column, label, unit in measures:
        values = columns.get(column)
        if values is not None and largest(values) > 0.0:
            figure = Figure()
            add_line(figure, run.times, values, label, unit, color=LINES[0], width=2.2)
            finish(figure, run, with_unit(label, unit), peak_time)
            figure.layout["showlegend"] = False
            figures.append(figure)
    return figures + _figures(run, sensor_quantities(run, sensor), peak_time)


def _figures(run: Run, quantities: list[Quantity], peak_time: float | None) -> list[Figure]:
    figures = (vector_figure(run, peak_time, q.components, q.label, q.unit) for q in quantities)
    return [figure for figure in figures if figure is not None]


def _vector(columns: Columns, name: str) -> dict[str, FloatArray]:
    return {axis: columns[name.format(axis)] for axis in "xyz" if name.format(axis) in columns}


def _summary_of(run: Run, sensor: str) -> dict[str, Any]:
    return dict(run.summary_part("sensors").get(sensor) or {})


def _mark_criteria(figure: Figure, criteria: dict[str, dict[str, float]]) -> None:
    """Add the window of the head injury criterion and the level held for 3 ms to the figure layout.

    The first of HIC15, HIC36 and HICd that `criteria` has is marked.
    """
    shapes, notes = figure.layout["shapes"], []
    window = next((name for name in ("HIC15", "HIC36", "HICd") if name in criteria), None)
    if window is not None:
        result = criteria[window]
        shade = {"fillcolor": "#b07d1e", "opacity": 0.14, "line": {"width": 0}}
        span = {"x0": result["start"], "x1": result["end"], "type": "rect"}
        shapes.append({**span, "y0": 0, "y1": 1, "yref": "y domain", **shade})
        middle = (result["start"] + result["end"]) / 2.0
        notes.append((middle, 0.0, f"{window} = {number(result['value'])}"))
    if "3ms" in criteria:
        result = criteria["3ms"]
        level, line = result["value"], {"color": INK, "width": 1.8}
        span = {"x0": result["start"], "x1": result["end"], "type": "line"}
        shapes.append({**span, "y0": level, "y1": level, "line": line})
        notes.append((result["end"], level, f"3 ms: {number(level)} g"))
    if notes:
        figure.layout["annotations"] = [
            {
                "x": x,
                "y": y,
                "text": text,
                "showarrow": False,
                "yanchor": "bottom",
                "xanchor": "center" if y == 0.0 else "left",
                "font": {"size": 12, "color": INK},
                "bgcolor": f"{PAPER}b3",
            }
            for x, y, text in notes
        ]


def extremes_table(run: Run) -> str:
    """Return the table of largest magnitudes over time of quantities of free bodies.

    It has their times and the magnitudes at the end, and is empty if no body moves.
    """
    rows = []
    for body in run.bodies:
        for quantity in body_quantities(run, body):
            magnitudes = quantity.magnitudes
            k = int(np.nanargmax(magnitudes))
            cells = [
                f"{number(float(magnitudes[k]))} {escape(quantity.unit)}",
                f"{number(float(run.times[k]))} {escape(run.units.time)}",
                f"{number(float(magnitudes[-1]))} {escape(quantity.unit)}",
            ]
            rows.append(named_row(body, quantity.label, cells))
    return named_table(("Body", "Quantity", "Largest", "at t =", "At the end"), rows)


def criteria_table(run: Run) -> str:
    """Return the table of the criteria of all sensors, with their times; empty without any."""
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
