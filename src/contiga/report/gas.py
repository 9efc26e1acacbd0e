"""Gas over time: pressure, temperature and volume of its chambers."""

from __future__ import annotations

from html import escape

import numpy as np

from contiga.io.units import with_unit
from contiga.report.figure import Figure
from contiga.report.html_tables import named_row, named_table
from contiga.report.lines import add_line, finish
from contiga.report.run_folder import Run
from contiga.report.style import LINES, number


def gas_figures(run: Run, peak_time: float | None) -> list[Figure]:
    """Return figures of pressure, temperature and volume over time; none without chambers.

    Each has a line for each chamber.
    """
    if not run.gas:
        return []
    units, figures = run.units, []
    volume = f"{units.length}³" if units.length else ""
    for label, unit, name in (
        ("Pressure", units.stress, "pressure"),
        ("Temperature", "K", "temperature"),
        ("Volume", volume, "volume"),
    ):
        figure = Figure()
        for k, (chamber, columns) in enumerate(run.gas.items()):
            look = {"color": LINES[k % len(LINES)], "width": 2.0}
            add_line(figure, run.times, columns[name], chamber, unit, **look)
        finish(figure, run, with_unit(label, unit), peak_time)
        figure.layout["showlegend"] = len(figure.data) > 1
        figures.append(figure)
    return figures


def gas_table(run: Run) -> str:
    """Return the table of chambers, with their maxima and enthalpies; empty without chambers."""
    units, rows = run.units, []
    volume = f"{units.length}³" if units.length else ""
    for name, columns in run.gas.items():
        pressure = columns["pressure"]
        at = int(np.argmax(pressure))
        slave = (run.summary_part("gas").get(name) or {}).get("slave", "")
        cells = [
            f"{number(float(pressure[at]))} {units.stress}",
            f"{number(float(run.times[at]))} {units.time}",
            f"{number(float(columns['temperature'].max()))} K",
            f"{number(float(columns['volume'].max()))} {volume}",
            f"{number(float(columns['flow_in'][-1]))} {units.energy}",
            f"{number(float(columns['flow_out'][-1]))} {units.energy}",
        ]
        rows.append(named_row(name, slave, list(map(escape, cells))))
    heads = ("Gas", "In slave", "Largest pressure", "at t =", "Hottest", "Largest volume")
    return named_table((*heads, "Enthalpy in", "Enthalpy out"), rows)
