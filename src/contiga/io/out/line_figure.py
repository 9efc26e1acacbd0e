"""Panels of lines as a matplotlib figure, without a window: what `plot` draws."""

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
    from contiga.io.out.shown_figure import ShownFigure


_INSIDE = 4
"""Lines whose legend has room inside the axes; that of more is beside them."""


class Line(NamedTuple):
    """One line of a panel."""

    name: str
    """What the legend calls it."""
    x: FloatArray
    """(n,)."""
    y: FloatArray
    """(n,); rows where either is NaN are passed over."""
    measured: bool = False
    """Whether it is the curve of a test: it is drawn dashed, in the colour of text."""


class Panel(NamedTuple):
    """Lines that share their axes."""

    x_label: str
    y_label: str
    lines: tuple[Line, ...]
    bands: tuple[FloatArray, ...] = ()
    """Corridors (k, 3): abscissa, lower and upper value."""
    legend: bool = True


def labelled(label: str, unit: str) -> str:
    """``label [unit]``, or the one of both that there is."""
    return f"{label} [{unit}]".strip() if unit else label


def draw_panels(panels: Sequence[Panel], title: str, path: str | Path | None = None) -> ShownFigure:
    """Draw panels, two in a row.

    Parameters
    ----------
    path : also write the picture there, in the format of its suffix (.png, .svg, .pdf)

    Raises
    ------
    InputError
        A suffix of no format.
    OutputError
        `path` cannot be written.
    """
    # Not by pyplot: a figure of its own opens no window and is freed with its last name.
    from contiga.io.out.shown_figure import ShownFigure

    rows, across = max(1, (len(panels) + 1) // 2), min(2, max(1, len(panels)))
    beside = any(panel.legend and len(panel.lines) > _INSIDE for panel in panels)
    size = ((4.6 + 1.6 * beside) * across, 0.5 + 2.5 * rows)
    figure = ShownFigure(figsize=size, layout="constrained", facecolor="white")
    for k, panel in enumerate(panels):
        axes = figure.add_subplot(rows, across, k + 1)
        for x, low, high in (band.T for band in panel.bands):
            axes.fill_between(x, low, high, color=INK, alpha=0.1, lw=0.0)
        ours = 0
        for line in panel.lines:
            # Areas and the like are measured at some steps only: the line goes on between them.
            known = np.isfinite(line.x) & np.isfinite(line.y)
            style = "--" if line.measured or ours >= len(LINES) else "-"
            colour = INK if line.measured else LINES[ours % len(LINES)]
            ours += not line.measured
            width = 1.2 if line.measured else 1.6
            axes.plot(line.x[known], line.y[known], style, color=colour, lw=width, label=line.name)
        axes.set_xlabel(panel.x_label, color=MUTED)
        axes.set_ylabel(panel.y_label, color=MUTED)
        axes.grid(color=GRID)
        axes.tick_params(colors=MUTED)
        axes.spines[["top", "right"]].set_visible(False)
        axes.spines[["left", "bottom"]].set_color(GRID)
        axes.margins(x=0.0)
        if panel.legend:
            look: dict[str, Any] = {"frameon": False, "fontsize": 8, "labelcolor": INK}
            if len(panel.lines) > _INSIDE:
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
