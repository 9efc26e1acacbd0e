"""Curves of channels over each other: of contacts, of the `[[plot]]` tables of a case, of tests."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.io.channels import Channel, channel_of
from contiga.io.column_units import column_kind
from contiga.io.units import with_unit
from contiga.report.figure import Figure
from contiga.report.lines import MAX_ROWS, add_line, finish, in_lines, largest, rows_drawn
from contiga.report.references import Reference, references_of, whole_name
from contiga.report.run_folder import Run
from contiga.report.runs import Named
from contiga.report.style import INK, LINES

_MAX_CONTACTS = 6
"""Largest number of contacts whose curves are drawn without being asked for."""
_BAND = f"{INK}1a"
_DASHES = ("solid", "dash", "dot", "dashdot")


class Curve(NamedTuple):
    """Channels of one figure, by their full names."""

    x: str
    """Channel of the abscissa."""
    y: tuple[str, ...]
    """Channels of one unit."""

    @property
    def label(self) -> str:
        """Label of the vertical axis: the channel, or the quantity of several; empty for ratios."""
        if len(self.y) == 1:
            return self.y[0]
        kind = column_kind(self.y[0])
        return {"ratio": "", "spin": "angular velocity", "seconds": "time"}.get(kind, kind)


def curves_of(run: Run) -> list[Curve]:
    """Return the curves of a run: of contacts, of `[[plot]]` tables of its case, and of tests.

    The first six contacts with a force have force over depth and pressure over strain. A test has a
    curve if no other shows its channels. Equal curves are given once, and those without a line
    (`channels_of`) are left out.
    """
    active = [name for name, columns in run.contacts.items() if largest(columns.get("force"))]
    depths = run.summary_part("depths")
    curves = []
    for contact in active[:_MAX_CONTACTS]:
        depth = depths.get(contact, f"{contact}.max_penetration")
        curves.append(Curve(depth, (f"{contact}.force",)))
        curves.append(Curve(f"{contact}.strain", (f"{contact}.max_pressure",)))
    for table in run.case.get("plot") or []:
        y = table["y"]
        names = [y] if isinstance(y, str) else y
        x = whole_name(run, table.get("x", "time"))
        curves.append(Curve(x, tuple(whole_name(run, name) for name in names)))
    pairs = {(curve.x, name) for curve in curves for name in curve.y}
    for test in references_of(run):
        if (test.x, test.channel) not in pairs:
            curves.append(Curve(test.x, (test.channel,)))
            pairs.add((test.x, test.channel))
    return [curve for curve in dict.fromkeys(curves) if channels_of(run, curve)]


class Line(NamedTuple):
    """The channels of a line: abscissa and value."""

    x: Channel
    y: Channel


def channels_of(run: Run, curve: Curve) -> list[Line]:
    """Return abscissa and value of each line of a curve for which the run has both channels."""
    lines = []
    for name in curve.y:
        try:
            x, y = (channel_of(run.history, run.summary, channel) for channel in (curve.x, name))
        except InputError:
            continue
        lines.append(Line(x, y))
    return lines


def curve_figure(
    runs: Sequence[Named],
    curve: Curve,
    references: Sequence[Reference],
    peak_time: float | None,
    *,
    label: str | None = None,
    colours: Sequence[str] = (),
    max_rows: int = MAX_ROWS,
) -> Figure:
    """Return the figure of a curve: a line for each run and channel, tests and their corridors.

    Several runs have a colour each; several channels then have a dash each, which the legend names.
    Rows that are not finite are left out, and tests of other channels.

    Parameters
    ----------
    runs : the runs
    curve : the curve
    references : tests of any channels, moved to where they are drawn
    peak_time : time that the scene of the page shows, marked in curves over time; None without one
    label : label of the vertical axis without its unit; that of the curve if omitted
    colours : colour of each run; the palette of all figures if omitted
    max_rows : largest number of rows of a line (`rows_drawn`)
    """
    figure = Figure()
    tests = [test for test in references if test.x == curve.x and test.channel in curve.y]
    bands = [test for test in tests if len(test.band)]
    for test in bands:  # their corridors
        x, low, high = test.band.T
        look: dict[str, Any] = {"fill": "toself", "fillcolor": _BAND, "hoverinfo": "skip"}
        look |= {"showlegend": False, "width": 0}
        edge, sides = np.concatenate([x, x[::-1]]), np.concatenate([low, high[::-1]])
        add_line(figure, edge, sides, f"corridor of {test.name}", "", **look)
        figure.data[-1].pop("hovertemplate")
    x_label, unit, in_legend = curve.x, "", set[str]()
    for row, (run, run_name) in enumerate(runs):
        for column, (x, y) in enumerate(channels_of(run, curve)):
            names = [run_name] * bool(run_name) + [y.name] * (len(curve.y) > 1 or not run_name)
            rows = np.flatnonzero(np.isfinite(x.values) & np.isfinite(y.values))
            if len(rows):
                rows = rows[rows_drawn(y.values[rows], max_rows=max_rows)]
            look = {"width": 2.0}
            if colours:
                look |= {"color": colours[row], "dash": _DASHES[column % len(_DASHES)]}
            else:
                # Colours distinguish the runs, or the channels if there is one run.
                first, second = (row, column) if len(runs) > 1 else (column, 0)
                turn, colour = divmod(first, len(LINES))
                look |= {"color": LINES[colour], "dash": _DASHES[(turn + second) % len(_DASHES)]}
            add_line(figure, x.values[rows], y.values[rows], " ".join(names), y.unit, **look)
            if len(runs) > 1 and len(curve.y) > 1:
                figure.data[-1] |= {"name": y.name, "showlegend": y.name not in in_legend}
                in_legend.add(y.name)
            x_label, unit = with_unit(x.name, x.unit), y.unit
    for test in tests:
        look = {"color": INK, "width": 1.6, "dash": "dash"}
        x_test, y_test = test.points.T
        add_line(figure, x_test, y_test, f"test {test.name}", unit, **look)
    over_time = curve.x == "time"
    finish(
        figure, runs[0].run, with_unit(label or curve.label, unit), peak_time if over_time else None
    )
    figure.layout["showlegend"] = len(figure.data) - len(bands) > 1
    if not over_time:
        figure.layout["xaxis"]["title"]["text"] = in_lines(x_label)
        figure.layout["hovermode"] = "closest"
        for trace in figure.data[len(bands) :]:
            trace["hovertemplate"] = trace["hovertemplate"].replace("%{y", "%{x:.5g}, %{y", 1)
    return figure
