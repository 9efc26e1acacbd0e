"""Draw a history for `Result.plot`: forces, penetration, energies and motion over time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.extras import require
from contiga.io.channels import channel_of
from contiga.io.out.line_figure import Line, Panel, draw_panels
from contiga.io.units import with_unit
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.io.out.shown_figure import ShownFigure

MAX_LINES = 8
"""Largest number of lines in a panel; the largest curves are drawn."""
_ENERGY_NAMES = ("kinetic", "strain", "contact", "friction", "damping", "hysteresis", "total")
_CONTACT_ENERGIES = ("stored", "friction", "damping", "hysteresis")
_VECTORS = (("v", "speed"), ("a", "acceleration"))


def plot_history(
    purpose: str,
    history: Mapping[str, FloatArray],
    summary: Mapping[str, Any],
    columns: Sequence[str] | None = None,
    path: str | Path | None = None,
    *,
    x: str | None = None,
    y: str | Sequence[str] | None = None,
) -> ShownFigure:
    """Draw `y` over `x`, or `columns` over time, or the default panels of a history.

    `purpose` begins the message about a missing package; the figure is also written to `path`.

    Raises
    ------
    InputError
        A column or channel that the run does not have; `x` without `y`, or `y` beside `columns`.
    MissingPackageError
        matplotlib is not installed.
    OutputError
        `path` cannot be written.
    """
    require(purpose, "matplotlib")
    units = summary.get("columns") or {}
    if (y is None and x is not None) or (y is not None and columns is not None):
        raise InputError(
            "a curve is one of y over x", where="y", found=y, allowed="y, and x if it is not time"
        )
    if y is not None:
        panels = _channel_panels(
            history, summary, x or "time", [y] if isinstance(y, str) else list(y)
        )
    elif columns is not None:
        panels = list(_column_panels(history, units, columns))
    else:
        panels = list(_standard_panels(history, units))
    return draw_panels(panels, str(summary.get("title") or ""), path)


def _channel_panels(
    history: Mapping[str, FloatArray], summary: Mapping[str, Any], x: str, names: Sequence[str]
) -> list[Panel]:
    """Return panels of channels over another channel, one for each unit.

    Raises `InputError` for a channel that the run does not have.
    """
    across = channel_of(history, summary, x, "x")
    channels = [channel_of(history, summary, name, "y") for name in names]
    panels = []
    for unit in dict.fromkeys(channel.unit for channel in channels):
        of_unit = [channel for channel in channels if channel.unit == unit]
        label = with_unit(of_unit[0].name if len(of_unit) == 1 else "", unit)
        lines = tuple(Line(channel.name, across.values, channel.values) for channel in of_unit)
        panels.append(
            Panel(with_unit(across.name, across.unit), label, lines, (), len(of_unit) > 1)
        )
    return panels


def _standard_panels(
    history: Mapping[str, FloatArray], units: Mapping[str, str]
) -> Iterator[Panel]:
    """Yield the default panels of a history, without curves that are zero throughout.

    They are forces and deepest penetrations of contacts, energies (of the contacts, if forces move
    nothing), and the magnitudes of velocities and accelerations.
    """
    over = _Time(history["time"], with_unit("time", units.get("time", "")))
    # Springs and sensors also have a force: contacts are the owners of a penetration. A single
    # contact has no name in its columns.
    contacts = {n.rpartition(".")[0] for n in history if n.endswith("max_penetration")}
    for column, label in (("force", "contact force"), ("max_penetration", "deepest penetration")):
        names = [name for name in history if name.rpartition(".")[2] == column]
        names = [n for n in names if n.rpartition(".")[0] in contacts]
        lines = {n.rpartition(".")[0] or label: history[n] for n in names}
        yield from _panel(over, label, units.get(names[0], "") if names else "", lines)
    energies = {n: history[f"energy.{n}"] for n in _ENERGY_NAMES if f"energy.{n}" in history}
    unit = units.get("energy.total", "")
    if not energies:  # forces move nothing: draw the energies of the contacts
        for name in _CONTACT_ENERGIES:
            parts = [history[n] for n in history if n.rpartition(".")[2] == f"energy_{name}"]
            energies[name] = np.sum(parts, axis=0) if parts else np.zeros(len(history["time"]))
        unit = next((units[n] for n in units if n.endswith("energy_stored")), "")
    yield from _panel(over, "energy", unit, energies)
    for letter, label in _VECTORS:
        lines = {}  # by body or sensor with this vector
        for name in history:
            owner, _, column = name.rpartition(".")
            axes = [f"{owner}.{letter}{axis}" for axis in "xyz"]
            if column == f"{letter}x" and all(axis in history for axis in axes):
                lines[owner] = np.sqrt(sum(history[axis] ** 2 for axis in axes))
        name = next((f"{owner}.{letter}x" for owner in lines), "")
        yield from _panel(over, label, units.get(name, ""), lines)


class _Time(NamedTuple):
    """The abscissa of panels over time."""

    values: FloatArray
    """(n,)."""
    label: str


def _panel(time: _Time, label: str, unit: str, lines: Mapping[str, FloatArray]) -> Iterator[Panel]:
    """Yield a panel of the `MAX_LINES` largest lines that are not zero throughout, if any."""
    sizes = {
        name: float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        for name, values in lines.items()
    }
    largest = sorted((name for name in sizes if sizes[name] > 0.0), key=lambda n: -sizes[n])
    drawn = {name: lines[name] for name in lines if name in largest[:MAX_LINES]}
    if drawn:
        yield _over_time(time, label, unit, drawn)


def _over_time(time: _Time, label: str, unit: str, lines: Mapping[str, FloatArray]) -> Panel:
    curves = tuple(Line(name, time.values, values) for name, values in lines.items())
    return Panel(time.label, with_unit(label, unit), curves, (), list(lines) != [label])


def _column_panels(
    history: Mapping[str, FloatArray], units: Mapping[str, str], columns: Sequence[str]
) -> Iterator[Panel]:
    """Yield a panel over time for each unit among the columns, or for one column.

    Raises `InputError` for a column that the history does not have.
    """
    names = [columns] if isinstance(columns, str) else list(columns)
    for name in names:
        if name not in history:
            matches = get_close_matches(name, history, n=1)
            raise InputError(
                "the history has no such column",
                where="columns",
                found=name,
                allowed=", ".join(list(history)[:12]) + (", …" if len(history) > 12 else ""),
                remedy=f"Did you mean {matches[0]}?" if matches else "",
            )
    over = _Time(history["time"], with_unit("time", units.get("time", "")))
    for unit in dict.fromkeys(units.get(name, "") for name in names):
        lines = {name: history[name] for name in names if units.get(name, "") == unit}
        yield _over_time(over, ", ".join(lines) if len(lines) == 1 else "", unit, lines)
