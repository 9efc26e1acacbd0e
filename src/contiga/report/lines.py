"""Figures over time: their style, their lines, and the number of rows of a line."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from textwrap import wrap
from typing import Any

import numpy as np

from contiga.io.units import with_unit
from contiga.records import FloatArray, IndexArray
from contiga.report.figure import Figure
from contiga.report.run_folder import Run
from contiga.report.style import GRID, INK, LINES, PAPER

FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"
CONFIG = {"displaylogo": False, "responsive": True}
PLOT_CONFIG = {
    **CONFIG,
    "modeBarButtons": [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
}
"""Buttons are named one by one: the standard set has some that send data elsewhere."""
_AXES = {"x": "#d08a80", "y": "#8fb996", "z": "#9db7d4"}
MAX_ROWS = 4000
"""Largest number of rows of a line: more than a picture has columns of pixels."""
BUTTONS = 34
"""Height above a figure for its buttons, pixels."""
_LABEL_LENGTH = 28
"""Largest number of characters of the label of an axis in one line."""
SHOWN = "shown"
"""Name of the line at the time that the scene of the page shows."""
_MIN_SHARE = 1e-6
"""Share of the largest component below which a component is not drawn: it would lie on the axis."""


def largest(values: FloatArray | None) -> float:
    """Return the largest finite magnitude; 0 if there is none."""
    if values is None:
        return 0.0
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def rows_drawn(*columns: FloatArray, max_rows: int = MAX_ROWS) -> IndexArray:
    """Return the rows of columns (n,) to draw, ascending: all, or the extremes of each stretch.

    Above `max_rows` rows, the columns are cut into equal stretches, so many that the smallest and
    the largest value of each column in each, with the first and the last row, are at most
    `max_rows`. NaN is no extreme.
    """
    n = len(columns[0])
    if n <= max_rows:
        return np.arange(n)
    edges = np.linspace(0, n, (max_rows - 2) // (2 * len(columns)) + 1).astype(np.intp)
    rows = [0, n - 1]
    for column in columns:
        low, high = (np.where(np.isnan(column), worst, column) for worst in (np.inf, -np.inf))
        for a, b in pairwise(edges):
            rows += [a + int(low[a:b].argmin()), a + int(high[a:b].argmax())]
    return np.unique(rows)


def add_line(
    figure: Figure, times: FloatArray, values: FloatArray, name: str, unit: str, **look: Any
) -> None:
    """Add a line of a column over time, with its unit in the hover text.

    Rows with NaN are left out, without a gap; of more than `MAX_ROWS` only extremes are drawn.

    Parameters
    ----------
    figure : the figure, extended in place
    times, values : (n,) abscissa and ordinate
    name : name in the legend
    unit : unit of the values, for the hover text
    look : colour, width and dash of the line; anything else is the trace's
    """
    line = {key: look.pop(key) for key in ("color", "width", "dash") if key in look}
    rows = np.flatnonzero(~np.isnan(values))
    if len(rows):
        rows = rows[rows_drawn(values[rows])]
    trace = {
        "type": "scatter",
        "x": times[rows],
        "y": values[rows],
        "name": name,
        "mode": "lines",
        "line": line,
        "hovertemplate": f"%{{y:.5g}} {unit}<extra>{name}</extra>",
    }
    figure.data.append(trace | look)


def add_components(
    figure: Figure, times: FloatArray, components: Mapping[str, FloatArray], unit: str
) -> bool:
    """Add thin lines of the components along x, y and z; return whether the figure has lines.

    Components up to 1e-6 of the largest are left out.
    """
    min_size = _MIN_SHARE * max(map(largest, components.values()), default=0.0)
    for axis, values in components.items():
        if largest(values) > min_size:
            add_line(figure, times, values, f"along {axis}", unit, color=_AXES[axis], width=1.3)
    return bool(figure.data)


def vector_figure(
    run: Run, peak_time: float | None, components: Mapping[str, FloatArray], label: str, unit: str
) -> Figure | None:
    """Return a figure of components by axis and their resultant over time; None if all are zero.

    Parameters
    ----------
    run : the run
    peak_time : time that the scene of the page shows; None without a scene
    components : columns (n,) by axis
    label, unit : name of the quantity, and its unit
    """
    if not any(largest(values) > 0.0 for values in components.values()):
        return None
    figure = Figure()
    add_components(figure, run.times, components, unit)
    resultant = np.sqrt(sum(values**2 for values in components.values()))
    add_line(figure, run.times, resultant, "resultant", unit, color=LINES[0], width=2.2)
    finish(figure, run, with_unit(label, unit), peak_time)
    return figure


def finish(
    figure: Figure, run: Run, label: str, peak_time: float | None, *, height: int = 310
) -> None:
    """Replace the layout of a figure over time: axes, the line at the peak, and the common style.

    `label` is that of the vertical axis, with its unit; `height` is in pixels.
    """
    axis = {"gridcolor": GRID, "zerolinecolor": "#c5cad0"}
    title = {"text": with_unit("Time", run.units.time), "standoff": 8}
    thin = {"showgrid": False, "linecolor": "#c5cad0", "ticks": "outside", "ticklen": 4}
    thin["automargin"] = True  # the legend stands below the title
    value = {"title": {"text": in_lines(label), "standoff": 8}, "rangemode": "tozero"}
    power = {"exponentformat": "power", "minexponent": 6, "automargin": True}
    peak_line = {
        "line": {"color": "#9aa3ad", "width": 1, "dash": "dot"},
        "name": SHOWN,
        "type": "line",
        "x0": peak_time,
        "x1": peak_time,
        "xref": "x",
        "y0": 0,
        "y1": 1,
        "yref": "y domain",
    }
    figure.layout = {
        "yaxis": {**value, **axis, **power},
        "xaxis": {"title": title, **axis, **thin},
        "shapes": [] if peak_time is None else [peak_line],
        "margin": {"l": 62, "r": 14, "t": BUTTONS, "b": 50},
        "font": {"family": FONT, "size": 13, "color": INK},
        "legend": {
            "font": {"size": 12},
            "orientation": "h",
            "yref": "container",
            "y": 0.0,
            "yanchor": "bottom",
            "x": 0.0,
        },
        "height": height,
        "hovermode": "x",
        "separators": ".\N{NARROW NO-BREAK SPACE}",
        "paper_bgcolor": PAPER,
        "plot_bgcolor": PAPER,
    }


def in_lines(label: str) -> str:
    """Return a label broken by ``<br>`` into lines of 28 characters, between words only."""
    return "<br>".join(wrap(label, _LABEL_LENGTH, break_long_words=False))
