"""Curves of the cases of a study over each other, on its page."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from contiga.errors import InputError
from contiga.io.out.stored import SUMMARY
from contiga.report.colours import scale_colours
from contiga.report.curves import curve_figure, curves_of
from contiga.report.figure import embedded, side_by_side
from contiga.report.lines import PLOT_CONFIG
from contiga.report.references import references_of
from contiga.report.runs import read_runs
from contiga.studies.one_case import CASES
from contiga.studies.row import DONE, Row

_MOST = 20
"""Cases whose curves are drawn."""
_ROWS = 400
"""Rows of a line at most: a page has many of them."""
_PALEST = 0.3
"""Share of the colour scale that is left out: too pale for a line on white."""


def curves_section(folder: Path, rows: Sequence[Row], label: str) -> str:
    """Curves as in the report of the first case, a line a case; empty where there are none.

    Parameters
    ----------
    folder : of the study
    rows : of its cases
    label : column whose values colour the lines: that of the first variable
    """
    whole = [
        row for row in rows if row.status == DONE and (_place(folder, row) / SUMMARY).is_file()
    ]
    if not whole:
        return ""
    chosen = [
        whole[k] for k in np.unique(np.linspace(0, len(whole) - 1, _MOST).round().astype(int))
    ]
    try:
        runs = read_runs([_place(folder, row) for row in chosen])
    except InputError:  # their folders are no longer whole
        return ""
    first, colours = runs[0].run, _colours([row.values.get(label) for row in chosen])
    tests = [one.moved(first) for one in references_of(first)]
    figures = []
    for k, curve in enumerate(curves_of(first)):
        figure = curve_figure(runs, curve, tests, None, colours=colours, most=_ROWS)
        figure.layout["showlegend"] = False
        figure.layout["margin"]["t"] = 20
        figures.append(embedded(figure, f"curve-{k}", PLOT_CONFIG))
    if not figures:
        return ""
    some = "A line is a case" if len(chosen) == len(rows) else f"Lines are {len(chosen)} cases"
    said = f"{some}, darker where {escape(label)} is greater or comes later."
    return f'<h2>Curves</h2>{side_by_side(figures)}<p class="caption">{said}</p>'


def _place(folder: Path, row: Row) -> Path:
    return folder / CASES / f"{row.number:04d}"


def _colours(values: Sequence[object]) -> list[str]:
    """A colour for each value: by its size among numbers, by its place among others."""
    if not all(isinstance(value, int | float) for value in values):
        texts = [repr(value) for value in values]
        values = [list(dict.fromkeys(texts)).index(text) for text in texts]
    sizes = np.array(values, np.float64)
    shares = (sizes - sizes.min()) / max(float(np.ptp(sizes)), 1e-300)
    rgb = (255.0 * scale_colours(_PALEST + (1.0 - _PALEST) * shares)).round().astype(int)
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in rgb.tolist()]
