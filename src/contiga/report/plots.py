"""Contacts over time: force, penetration, area, count, and the energies of the contacts."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.io.units import with_unit
from contiga.report.figure import Figure
from contiga.report.lines import add_components, add_line, finish, largest, rows_drawn
from contiga.report.run_folder import Run
from contiga.report.style import INK, LINES, MUTED

_PANELS = (
    ("force", "Force", "force"),
    ("max_penetration", "Deepest penetration", "length"),
    ("area", "Contact area", "area"),
    ("n_contact", "Nodes in contact", ""),
)
_CONTACT_ENERGIES = {
    "energy_stored": "stored",
    "energy_hysteresis": "hysteresis",
    "energy_damping": "damping",
    "energy_friction": "friction",
}
_SYSTEM_ENERGIES = ("kinetic", "strain", "contact", "friction", "damping", "hysteresis")


def history_figures(run: Run, peak_time: float | None) -> list[Figure]:
    """Return figures of force, penetration, area and count over time, a line for each contact.

    A quantity that is zero throughout has no figure, and of several contacts one that never touches
    has no line. The force of an only contact has its components, too. If the run has no energies of
    the whole system, a last figure shows those of all contacts: stored and dissipated ones stacked
    under the work, so that the gap is the error.
    """
    figures = []
    only_one = len(run.contacts) == 1
    for column, label, kind in _PANELS:
        if not any(largest(columns.get(column)) > 0.0 for columns in run.contacts.values()):
            continue
        figure, unit = Figure(), getattr(run.units, kind) if kind else ""
        has_components = False
        if only_one and column == "force":
            (columns,) = run.contacts.values()
            axes = {axis: columns[f"force_{axis}"] for axis in "xyz" if f"force_{axis}" in columns}
            has_components = add_components(figure, run.times, axes, unit)
        for i, (name, columns) in enumerate(run.contacts.items()):
            if column in columns and (only_one or has_contact(run, name)):
                name = "magnitude" if has_components else name
                colour = LINES[i % len(LINES)]
                # areas are measured at the written steps; the line connects them
                add_line(figure, run.times, columns[column], name, unit, color=colour, width=2.2)
        finish(figure, run, with_unit(label, unit), peak_time)
        figure.layout["showlegend"] = has_components or not only_one
        figures.append(figure)
    work = run.total("work")
    if not run.energy and largest(work) > 0.0:
        figure = _stack(run, {n: run.total(c) for c, n in _CONTACT_ENERGIES.items()}, work)
        finish(figure, run, with_unit("Energy of contact", run.units.energy), peak_time)
        figures.append(figure)
    return figures


def has_contact(run: Run, contact: str) -> bool:
    """Return whether a contact ever had points in contact, or a force."""
    columns = run.contacts[contact]
    return any(largest(columns.get(name)) > 0.0 for name in ("n_contact", "force"))


def energy_figure(run: Run, peak_time: float | None) -> Figure | None:
    """Return a figure of the energies of the system, stacked under their sum with the error.

    That sum is the initial energy and what came in from outside; the error is a line of its own.
    The energy of gas is left out if it is ever negative. None if all energies are zero.
    """
    layers = {name: run.energy[name] for name in _SYSTEM_ENERGIES if name in run.energy}
    # Negative energies cannot be stacked.
    if "gas" in run.energy and run.energy["gas"].min() >= 0.0:
        layers["gas"] = run.energy["gas"]
    if not any(largest(values) > 0.0 for values in layers.values()):
        return None
    error = run.energy.get("error", np.zeros(len(run.times)))
    supplied = sum(layers.values()) + error
    figure = _stack(run, layers, supplied, "initial and external")
    look = {"color": MUTED, "width": 1.4, "dash": "dot"}
    add_line(figure, run.times, error, "error", run.units.energy, **look)
    finish(figure, run, with_unit("Energy", run.units.energy), peak_time, height=400)
    return figure


def _stack(run: Run, layers: dict[str, Any], top: Any, name: str = "work") -> Figure:
    """Return a figure of the nonzero layers (n,), stacked, and a dashed line of `top` (n,)."""
    figure, unit = Figure(), run.units.energy
    nonzero = {name: values for name, values in layers.items() if largest(values) > 0.0}
    rows = rows_drawn(top, *nonzero.values())  # the layers of a stack share their rows
    for i, (layer, values) in enumerate(layers.items()):
        if layer in nonzero:
            look = {"color": LINES[i % len(LINES)], "width": 0.8, "stackgroup": "energy"}
            add_line(figure, run.times[rows], values[rows], layer, unit, **look)
    add_line(figure, run.times[rows], top[rows], name, unit, color=INK, width=1.6, dash="dash")
    return figure
