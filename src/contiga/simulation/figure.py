"""`Result.plot`: what users look at first, over time: forces, penetration, energies, motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.extras import require
from contiga.io.out.files import atomic_write
from contiga.io.out.palette import GRID, INK, LINES, MUTED
from contiga.records import FloatArray

if TYPE_CHECKING:
    from contiga.simulation.shown_figure import ShownFigure

MOST_LINES = 8
"""Lines that a panel has at most, the largest: more could not be told apart."""
_ENERGIES = ("kinetic", "strain", "contact", "friction", "damping", "hysteresis", "total")
_OF_CONTACT = ("stored", "friction", "damping", "hysteresis")
_VECTORS = (("v", "speed"), ("a", "acceleration"))


class Panel(NamedTuple):
    """Lines over time that share an axis."""

    label: str
    unit: str
    lines: dict[str, FloatArray]
    """(n,) each, by what the legend calls it; NaN where there is no value."""


def plot_history(
    purpose: str,
    history: Mapping[str, FloatArray],
    summary: Mapping[str, Any],
    columns: Sequence[str] | None = None,
    path: str | Path | None = None,
) -> ShownFigure:
    """The figure of a history; `purpose` is what a message about a missing package begins with.

    Raises
    ------
    InputError
        A column that the history does not have.
    MissingPackageError
        matplotlib is not installed.
    OutputError
        `path` cannot be written.
    """
    require(purpose, "matplotlib")
    units = summary.get("columns") or {}
    panels = list(
        _standard(history, units) if columns is None else _chosen(history, units, columns)
    )
    # Not by pyplot: a figure of its own opens no window and is freed with its last name.
    from contiga.simulation.shown_figure import ShownFigure

    time, unit = history["time"], units.get("time", "")
    rows, across = max(1, (len(panels) + 1) // 2), min(2, max(1, len(panels)))
    size = (4.6 * across, 0.5 + 2.5 * rows)
    figure = ShownFigure(figsize=size, layout="constrained", facecolor="white")
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(rows, across, k + 1)
        for i, (name, values) in enumerate(panel.lines.items()):
            # Areas and the like are measured at some steps only: the line goes on between them.
            known = np.isfinite(values)
            style = "-" if i < len(LINES) else "--"
            colour = LINES[i % len(LINES)]
            axes.plot(time[known], values[known], style, color=colour, lw=1.6, label=name)
        label = f"{panel.label} [{panel.unit}]" if panel.unit else panel.label
        axes.set_xlabel((f"time [{unit}]" if unit else "time"), color=MUTED)
        axes.set_ylabel(label.strip(), color=MUTED)
        axes.grid(color=GRID)
        axes.tick_params(colors=MUTED)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color(GRID)
        axes.margins(x=0.0)
        if list(panel.lines) != [panel.label]:
            axes.legend(frameon=False, fontsize=8, labelcolor=INK)
    if title := summary.get("title"):
        figure.suptitle(str(title), color=INK, fontsize=11, x=0.02, ha="left")
    if path is not None:
        suffix = Path(path).suffix.lower().removeprefix(".") or "png"
        formats = figure.canvas.get_supported_filetypes()
        if suffix not in formats:
            raise InputError(
                "no format of pictures has this suffix",
                where=str(path),
                found=f".{suffix}",
                allowed=", ".join(f".{name}" for name in formats),
            )
        with atomic_write(path) as temporary:
            figure.savefig(temporary, dpi=110, format=suffix)
    return figure


def _standard(history: Mapping[str, FloatArray], units: Mapping[str, str]) -> Iterator[Panel]:
    """Panels of what is not zero throughout."""
    # Springs and sensors have a force, too: contacts are those with a penetration, and the one
    # without a name where there is one only.
    contacts = {n.rpartition(".")[0] for n in history if n.endswith("max_penetration")}
    for column, label in (("force", "contact force"), ("max_penetration", "deepest penetration")):
        names = [name for name in history if name.rpartition(".")[2] == column]
        names = [n for n in names if n.rpartition(".")[0] in contacts]
        lines = {n.rpartition(".")[0] or label: history[n] for n in names}
        yield from _panel(label, units.get(names[0], "") if names else "", lines)
    energies = {n: history[f"energy.{n}"] for n in _ENERGIES if f"energy.{n}" in history}
    unit = units.get("energy.total", "")
    if not energies:  # nothing is moved by forces: where the work on the contacts went
        for name in _OF_CONTACT:
            parts = [history[n] for n in history if n.rpartition(".")[2] == f"energy_{name}"]
            energies[name] = np.sum(parts, axis=0) if parts else np.zeros(len(history["time"]))
        unit = next((units[n] for n in units if n.endswith("energy_stored")), "")
    yield from _panel("energy", unit, energies)
    for letter, label in _VECTORS:
        lines = {}  # of each body and sensor that has the vector
        for name in history:
            owner, _, column = name.rpartition(".")
            axes = [f"{owner}.{letter}{axis}" for axis in "xyz"]
            if column == f"{letter}x" and all(axis in history for axis in axes):
                lines[owner] = np.sqrt(sum(history[axis] ** 2 for axis in axes))
        name = next((f"{owner}.{letter}x" for owner in lines), "")
        yield from _panel(label, units.get(name, ""), lines)


def _panel(label: str, unit: str, lines: Mapping[str, FloatArray]) -> Iterator[Panel]:
    """A panel of the lines that are somewhere not zero, if there are any."""
    sizes = {
        name: float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
        for name, values in lines.items()
    }
    largest = sorted((name for name in sizes if sizes[name] > 0.0), key=lambda n: -sizes[n])
    kept = {name: lines[name] for name in lines if name in largest[:MOST_LINES]}
    if kept:
        yield Panel(label, unit, kept)


def _chosen(
    history: Mapping[str, FloatArray], units: Mapping[str, str], columns: Sequence[str]
) -> Iterator[Panel]:
    """A panel for each unit among the columns."""
    given = [columns] if isinstance(columns, str) else list(columns)
    for name in given:
        if name not in history:
            near = get_close_matches(name, history, n=1)
            raise InputError(
                "the history has no such column",
                where="columns",
                found=name,
                allowed=", ".join(list(history)[:12]) + (", …" if len(history) > 12 else ""),
                remedy=f"Did you mean {near[0]}?" if near else "",
            )
    for unit in dict.fromkeys(units.get(name, "") for name in given):
        lines = {name: history[name] for name in given if units.get(name, "") == unit}
        yield Panel(", ".join(lines) if len(lines) == 1 else "", unit, lines)
