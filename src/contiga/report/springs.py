"""Springs over time: their forces, how far they are drawn out, and what they hold and lose."""

from __future__ import annotations

from html import escape

import numpy as np

from contiga.records import FloatArray
from contiga.report.figure import Figure
from contiga.report.html_tables import named_row, named_table
from contiga.report.lines import add_line, finish, largest, with_unit
from contiga.report.run_folder import Columns, Run
from contiga.report.style import LINES, number

_LOST = ("energy_hysteresis", "energy_damping")


def spring_figures(run: Run, peak_time: float | None) -> list[Figure]:
    """Force and elongation over time, a line a spring."""
    units = run.units
    figures = []
    for label, unit, told in (
        ("Force, tension positive", units.force, _force),
        ("Elongation", units.length, lambda columns: columns.get("elongation")),
    ):
        figure = Figure()
        for k, (name, columns) in enumerate(run.springs.items()):
            values = told(columns)
            if largest(values) > 0.0:
                look = {"color": LINES[k % len(LINES)], "width": 2.0}
                add_line(figure, run.times, values, name, unit, **look)
        if figure.data:
            finish(figure, run, with_unit(label, unit), peak_time)
            figure.layout["showlegend"] = len(figure.data) > 1
            figures.append(figure)
    return figures


def spring_table(run: Run) -> str:
    """Of each spring its largest force and elongation, when, and its energies."""
    rows = [_row(run, name, columns) for name, columns in run.springs.items()]
    heads = ("Spring", "Between", "Largest force", "at t =", "Longest by", "Shortest by")
    return named_table((*heads, "Stored at most", "Lost"), rows)


def _row(run: Run, name: str, columns: Columns) -> str:
    facts = run.told("springs").get(name) or {}
    between, cls = " – ".join(facts.get("between") or ()), facts.get("filter")
    force, units = _force(columns), run.units
    at = int(np.argmax(np.abs(force)))
    lost = sum(float(columns[key][-1]) for key in _LOST if key in columns)
    elongation = columns["elongation"]
    cells = [
        f"{number(float(force[at]))} {units.force}",
        f"{number(float(run.times[at]))} {units.time}",
        f"{number(max(float(elongation.max()), 0.0))} {units.length}",
        f"{number(max(float(-elongation.min()), 0.0))} {units.length}",
        f"{number(float(columns['energy_stored'].max()))} {units.energy}",
        f"{number(lost)} {units.energy}",
    ]
    return named_row(f"{name} · {cls}" if cls else name, between, list(map(escape, cells)))


def _force(columns: Columns) -> FloatArray:
    """Filtered where it is."""
    return columns["filtered_force"] if "filtered_force" in columns else columns["force"]
