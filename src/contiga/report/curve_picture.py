"""Curves of one run or several as a picture: PNG, SVG or PDF."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from contiga.errors import InputError
from contiga.extras import require
from contiga.io.channels import channel_of
from contiga.io.out.line_figure import Line, Panel, draw_panels
from contiga.io.units import with_unit
from contiga.report.curves import Curve, channels_of, curves_of
from contiga.report.references import references_of, whole_name
from contiga.report.runs import read_runs


def draw_curves(
    folders: Sequence[str | Path],
    path: str | Path,
    *,
    x: str | None = None,
    y: Sequence[str] = (),
) -> None:
    """Write a picture of curves of runs, a panel each, with the tests of the first run's case.

    Later runs that lack a channel have no line of it.

    Parameters
    ----------
    folders : output folders of runs; all is drawn in the units of the first
    path : picture to write, in the format of its suffix (.png, .svg, .pdf)
    x : channel of the abscissa of `y`, time if omitted; without `y` it has no effect
    y : channels, one panel each; if omitted the curves in the report of the first run, over
        abscissae of their own, several channels in a panel as in the report

    Raises
    ------
    FileError
        A folder is not that of a run.
    InputError
        A channel that the first run lacks, nothing to draw, only some runs with units, or a suffix
        of no picture format.
    MissingPackageError
        matplotlib is not installed.
    OutputError
        The picture cannot be written.
    """
    require("a picture of curves", "matplotlib")
    runs = read_runs(folders)
    first = runs[0].run
    for key, name in [*([("x", x)] if x else []), *(("y", name) for name in y)]:
        channel_of(first.history, first.summary, name, key)
    x_name = whole_name(first, x or "time")
    curves = [Curve(x_name, (whole_name(first, name),)) for name in y]
    references = [reference.moved(first) for reference in references_of(first)]
    panels = []
    for curve in curves or curves_of(first):
        lines, labels = [], ("", "")
        for run, run_name in runs:
            for across, value in channels_of(run, curve):
                names = [run_name] * (len(runs) > 1) + [value.name] * (len(curve.y) > 1)
                lines.append(Line(" ".join(names) or value.name, across.values, value.values))
                labels = with_unit(across.name, across.unit), with_unit(curve.label, value.unit)
        tests = [test for test in references if test.x == curve.x and test.channel in curve.y]
        for test in tests:
            lines.append(Line(f"test {test.name}", test.points[:, 0], test.points[:, 1], True))
        bands = tuple(test.band for test in tests if len(test.band))
        panels.append(Panel(*labels, tuple(lines), bands, len(lines) > 1))
    if not panels:
        raise InputError(
            "the report of the run has no curves", where=str(folders[0]), allowed="channels as y"
        )
    draw_panels(panels, str(first.summary.get("title") or ""), path)
