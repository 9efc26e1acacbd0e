"""Panels of lines as a matplotlib figure without a window."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.io.out.files import atomic_write
from contiga.io.out.palette import GRID, INK, LINES, MUTED
from contiga.records import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from contiga.io.out.shown_figure import ShownFigure


_MAX_INSIDE = 4
"""Largest number of lines with a legend inside the axes; more have it beside them."""


class Line(NamedTuple):
    """One line of a panel."""

    name: str
    """Name in the legend."""
    x: FloatArray
    """(n,) abscissa."""
    y: FloatArray
    """(n,) values; rows where `x` or `y` is NaN are not drawn."""
    measured: bool = False
    """Whether it is the curve of a test, drawn dashed in the colour of text."""


class Panel(NamedTuple):
    """Lines that share their axes."""

    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    bands: tuple[FloatArray, ...] = ()
    """Corridors (k, 3): abscissa, lower and upper value."""
    legend: bool = True
    """Whether a legend names the lines."""


def finish_axes(axes: Axes, x_label: str, y_label: str) -> None:
    """Label axes, draw their grid, hide the upper and right border, and colour all in grey."""
    axes.set_xlabel(x_label, color=MUTED)
    axes.set_ylabel(y_label, color=MUTED)
    axes.grid(color=GRID)
    axes.tick_params(colors=MUTED)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(GRID)


def draw_panels(panels: Sequence[Panel], title: str, path: str | Path | None = None) -> ShownFigure:
    """Return a figure of panels, two in a row.

    Measured lines are dashed in the colour of text, computed ones in the colours of the palette in
    turn, dashed once these are used up. Rows with NaN or infinity are left out of a line. Bands are
    shaded; a legend of more than `_MAX_INSIDE` lines stands beside its panel.

    Parameters
    ----------
    panels : panels in the order of reading
    title : title of the figure; "" for none
    path : also write the picture there, in the format of its suffix (.png, .svg, .pdf), .png
        without one; an older file is replaced

    Raises
    ------
    InputError
        No picture format has the suffix of `path`.
    OutputError
        `path` cannot be written.
    """
    # Not by pyplot: a figure of its own opens no window and is freed with its last name.
    from contiga.io.out.shown_figure import ShownFigure

    rows, columns = max(1, (len(panels) + 1) // 2), min(2, max(1, len(panels)))
    legend_outside = any(panel.legend and len(panel.lines) > _MAX_INSIDE for panel in panels)
    size = ((4.6 + 1.6 * legend_outside) * columns, 0.5 + 2.5 * rows)
    figure = ShownFigure(figsize=size, layout="constrained", facecolor="white")
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(rows, columns, k + 1)
        for x, low, high in (band.T for band in panel.bands):
            axes.fill_between(x, low, high, color=INK, alpha=0.1, lw=0.0)
        n_computed = 0
        for line in panel.lines:
            # Some columns, such as areas, have values at some steps only: the line connects them.
            is_finite = np.isfinite(line.x) & np.isfinite(line.y)
            style = "--" if line.measured or n_computed >= len(LINES) else "-"
            colour = INK if line.measured else LINES[n_computed % len(LINES)]
            n_computed += not line.measured
            width = 1.2 if line.measured else 1.6
            x, y = line.x[is_finite], line.y[is_finite]
            axes.plot(x, y, style, color=colour, lw=width, label=line.name)
        finish_axes(axes, panel.x_label, panel.y_label)
        axes.margins(x=0.0)
        if panel.legend:
            look: dict[str, Any] = {"frameon": False, "fontsize": 8, "labelcolor": INK}
            if len(panel.lines) > _MAX_INSIDE:
                look |= {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
            axes.legend(**look)
    if title:
        figure.suptitle(title, color=INK, fontsize=11, x=0.02, ha="left")
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
