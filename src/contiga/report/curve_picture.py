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
from contiga.report.references import Reference, references_of, whole_name
from contiga.report.runs import Named, read_runs


def draw_curves(
    folders: Sequence[str | Path],
    path: str | Path,
    *,
    x: str | None = None,
    y: Sequence[str] = (),
) -> None:
    """Draw curves of runs over each other, with the tests that the case of the first run names.

    Parameters
    ----------
    folders : output folders of runs; all is drawn in the units of the first
    path : picture to write, in the format of its suffix (.png, .svg, .pdf)
    x : channel of the abscissa, time if omitted
    y : channels, one panel each; the curves in the report of the first run if omitted

    Raises
    ------
    FileError
        A folder is not that of a run.
    InputError
        A channel that the first run lacks, nothing to draw, or a suffix of no picture format.
    MissingPackageError
        matplotlib is not installed.
    OutputError
        The picture cannot be written.
    """
    require("a picture of curves", "matplotlib")
    runs = read_runs(folders)
    first = runs[0].run
    for key, name in [*([("x", x)] if x else []), *(("y", one) for one in y)]:
        channel_of(first.history, first.summary, name, key)
    across = whole_name(first, x or "time")
    curves = [Curve(across, (whole_name(first, name),)) for name in y]
    references = [one.moved(first) for one in references_of(first)]
    panels = [_panel(runs, curve, references) for curve in curves or curves_of(first)]
    if not panels:
        raise InputError(
            "the report of the run has no curves", where=str(folders[0]), allowed="channels as y"
        )
    draw_panels(panels, str(first.summary.get("title") or ""), path)


def _panel(runs: Sequence[Named], curve: Curve, references: Sequence[Reference]) -> Panel:
    lines, labels = [], ("", "")
    for run, called in runs:
        for across, value in channels_of(run, curve):
            name = " ".join([called] * (len(runs) > 1) + [value.name] * (len(curve.y) > 1))
            lines.append(Line(name or value.name, across.values, value.values))
            labels = with_unit(across.name, across.unit), with_unit(curve.label, value.unit)
    tests = [one for one in references if one.x == curve.x and one.channel in curve.y]
    lines += [Line(f"test {one.name}", one.points[:, 0], one.points[:, 1], True) for one in tests]
    bands = tuple(one.band for one in tests if len(one.band))
    return Panel(*labels, tuple(lines), bands, len(lines) > 1)
