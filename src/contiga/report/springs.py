"""Springs over time: forces, elongations, and energies stored and dissipated."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import Any

import numpy as np

from contiga.io.units import with_unit
from contiga.records import FloatArray
from contiga.report.figure import Figure
from contiga.report.html_tables import named_row, named_table
from contiga.report.lines import add_line, finish, largest
from contiga.report.run_folder import Columns, Run
from contiga.report.style import LINES, number

_LOST = ("energy_hysteresis", "energy_damping")


def spring_figures(run: Run, peak_time: float | None) -> list[Figure]:
    """Return figures of force, elongation and length paid out over time, a line for each spring.

    A spring whose quantity is zero throughout has no line, and a quantity without lines no figure.
    The force is the filtered one if the spring has a filter. A dotted line marks `peak_time`, if it
    is not None.
    """
    units = run.units
    figures = []
    for label, unit, values_of in (
        ("Force, tension positive", units.force, _force),
        ("Elongation", units.length, lambda columns: columns.get("elongation")),
        ("Paid out", units.length, lambda columns: columns.get("paid_out")),
    ):
        figure = Figure()
        for k, (name, columns) in enumerate(run.springs.items()):
            values = values_of(columns)
            if largest(values) > 0.0:
                look = {"color": LINES[k % len(LINES)], "width": 2.0}
                add_line(figure, run.times, values, name, unit, **look)
        if figure.data:
            finish(figure, run, with_unit(label, unit), peak_time)
            figure.layout["showlegend"] = len(figure.data) > 1
            figures.append(figure)
    return figures


def spring_table(run: Run) -> str:
    """Return the table of springs: largest force and its time, elongations, and energies.

    The force is that of largest magnitude, with its sign, filtered if there is a filter. The energy
    lost is that to hysteresis and damping at the end. The table is empty without springs.
    """
    units, rows = run.units, []
    for name, columns in run.springs.items():
        facts = run.summary_part("springs").get(name) or {}
        between, cls = " – ".join(facts.get("between") or ()), facts.get("filter")
        force, elongation = _force(columns), columns["elongation"]
        k = int(np.argmax(np.abs(force)))
        lost = sum(float(columns[key][-1]) for key in _LOST if key in columns)
        cells = [
            f"{number(float(force[k]))} {units.force}",
            f"{number(float(run.times[k]))} {units.time}",
            f"{number(max(float(elongation.max()), 0.0))} {units.length}",
            f"{number(max(float(-elongation.min()), 0.0))} {units.length}",
            f"{number(float(columns['energy_stored'].max()))} {units.energy}",
            f"{number(lost)} {units.energy}",
        ]
        title = f"{name} · {cls}" if cls else name
        rows.append(named_row(title, between, list(map(escape, cells))))
    heads = ("Spring", "Between", "Largest force", "at t =", "Longest by", "Shortest by")
    return named_table((*heads, "Stored at most", "Lost"), rows)


def device_table(run: Run) -> str:
    """Return the table of the belt devices of springs; empty without devices.

    It has the lengths paid out and pulled in, the times of locking and release, and the work of the
    pretensioner.
    """
    units, rows = run.units, []
    for name, columns in run.springs.items():
        if "paid_out" not in columns:
            continue
        facts, paid_out = run.summary_part("springs").get(name) or {}, columns["paid_out"]
        cells = [
            f"{number(float(paid_out.max()))} {units.length}",
            f"{number(float(columns['pulled_in'][-1]))} {units.length}",
            _event_time(facts, "locked", units.time),
            _event_time(facts, "released", units.time),
            f"{number(float(columns['energy_pretension'][-1]))} {units.energy}",
        ]
        rows.append(named_row(name, "", list(map(escape, cells))))
    heads = ("Devices of", "", "Paid out at most", "Pulled in", "Locked at t =", "Released at t =")
    return named_table((*heads, "Work of the pretensioner"), rows) if rows else ""


def _event_time(facts: Mapping[str, Any], event: str, unit: str) -> str:
    """Return the time of an event; "never" if it has not happened, a dash if it cannot."""
    if event not in facts:
        return "–"
    return "never" if facts[event] is None else f"{number(float(facts[event]))} {unit}"


def slip_ring_table(run: Run) -> str:
    """Return the table of slip rings: largest slip, range of angles, friction; empty without any.

    The slip is that of largest magnitude, with its sign; angles are in degrees.
    """
    units, rows = run.units, []
    for name, columns in run.slip_rings.items():
        facts = run.summary_part("slip_rings").get(name) or {}
        slipped, angle = columns["slipped"], np.degrees(columns["angle"])
        cells = [
            number(float(facts.get("friction", np.nan))),
            f"{number(float(slipped[int(np.argmax(np.abs(slipped)))]))} {units.length}",
            f"{number(float(angle.min()))} to {number(float(angle.max()))}°",
            f"{number(float(columns['energy_friction'][-1]))} {units.energy}",
        ]
        between = " – ".join(facts.get("between") or ())
        rows.append(named_row(name, between, list(map(escape, cells))))
    heads = ("Slip ring", "Between", "Friction", "Slipped at most", "Turns by", "Lost")
    return named_table(heads, rows) if rows else ""


def _force(columns: Columns) -> FloatArray:
    """Return the force, filtered if there is a filter."""
    return columns["filtered_force"] if "filtered_force" in columns else columns["force"]
