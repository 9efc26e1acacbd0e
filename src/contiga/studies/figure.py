"""`Study.plot`: the collected quantities over the variable, or over the cases."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from contiga.errors import InputError
from contiga.extras import require
from contiga.io.naming import closest
from contiga.io.out.line_figure import finish_axes
from contiga.io.out.palette import LINES
from contiga.io.units import with_unit
from contiga.studies.table import Table

if TYPE_CHECKING:
    from contiga.io.out.shown_figure import ShownFigure

_MAX_ACROSS = 3
"""Largest number of panels in a row."""
_MAX_PANELS = 9
"""Largest number of panels where no columns are named."""


def plot_table(purpose: str, table: Table, columns: Sequence[str] | None = None) -> ShownFigure:
    """Return a figure with a panel for each column; `purpose` begins the error without matplotlib.

    Without `columns` these are the first nine quantities. They are drawn over the variable if it is
    the only one and of numbers, with a line, and else over the numbers of the cases, as points.

    Raises
    ------
    InputError
        The table does not have a column, or the column holds text.
    MissingPackageError
        matplotlib is not installed.
    """
    require(purpose, "matplotlib")
    from contiga.io.out.shown_figure import ShownFigure

    names = list(table.quantities[:_MAX_PANELS] if columns is None else columns)
    drawable = [
        column
        for column, values in table.columns.items()
        if all(isinstance(value, int | float) for value in values)
    ]
    for name in names:
        if name not in drawable:
            raise InputError(
                "the study has no such column of numbers",
                where="columns",
                found=name,
                allowed=", ".join(drawable),
                remedy=closest(name, drawable),
            )
    numeric = [name for name in table.variables if name in drawable]
    over = numeric[0] if len(table.variables) == len(numeric) == 1 else "case"
    x = np.array(table.columns[over], dtype=float)
    order = np.argsort(x, kind="stable")
    across = min(_MAX_ACROSS, max(1, len(names)))
    rows = max(1, -(-len(names) // across))
    size = (3.6 * across, 0.3 + 2.6 * rows)
    figure = ShownFigure(figsize=size, layout="constrained", facecolor="white")
    for k, name in enumerate(names):
        axes = figure.add_subplot(rows, across, k + 1)
        values = np.array(table.columns[name], dtype=float)[order]
        axes.plot(x[order], values, "o-" if over != "case" else "o", color=LINES[0], lw=1.4, ms=4)
        labels = (with_unit(column, table.units.get(column, "")) for column in (over, name))
        finish_axes(axes, *labels)
    return figure
