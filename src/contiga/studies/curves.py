"""Curves of the cases of a study, drawn over each other on its page."""

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

_MAX_CASES = 20
"""Largest number of cases whose curves are drawn."""
_MAX_ROWS = 400
"""Largest number of rows of a line: a page has many lines."""
_PALEST = 0.3
"""Fraction of the colour scale that is left out, too pale for a line on white."""


def curves_section(folder: Path, rows: Sequence[Row], label: str) -> str:
    """Return the curves of the report of the first case with a line for each case, as HTML.

    At most 20 complete cases are drawn, evenly chosen. The text is empty if there are no curves, or
    a folder cannot be read. Colours are by size for numbers, by first appearance for other values.

    Parameters
    ----------
    folder : folder of the study
    rows : rows of its cases
    label : column whose values colour the lines, the first variable
    """
    folders = {row.number: folder / CASES / f"{row.number:04d}" for row in rows}
    complete = [
        row for row in rows if row.status == DONE and (folders[row.number] / SUMMARY).is_file()
    ]
    if not complete:
        return ""
    sample = np.unique(np.linspace(0, len(complete) - 1, _MAX_CASES).round().astype(int))
    cases = [complete[k] for k in sample]
    try:
        runs = read_runs([folders[row.number] for row in cases])
    except InputError:  # their folders are incomplete
        return ""
    first, values = runs[0].run, [row.values.get(label) for row in cases]
    texts = [repr(value) for value in values]
    are_numbers = all(isinstance(value, int | float) for value in values)
    ranks = [list(dict.fromkeys(texts)).index(text) for text in texts]
    sizes = np.array(values if are_numbers else ranks, np.float64)
    shares = (sizes - sizes.min()) / max(float(np.ptp(sizes)), 1e-300)
    rgb = (255.0 * scale_colours(_PALEST + (1.0 - _PALEST) * shares)).round().astype(int)
    colours = [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in rgb.tolist()]
    tests = [reference.moved(first) for reference in references_of(first)]
    figures = []
    for k, curve in enumerate(curves_of(first)):
        figure = curve_figure(runs, curve, tests, None, colours=colours, max_rows=_MAX_ROWS)
        if len(curve.y) == 1:
            figure.layout["showlegend"] = False
        figures.append(embedded(figure, f"curve-{k}", PLOT_CONFIG))
    if not figures:
        return ""
    lines = "A line is a case" if len(cases) == len(rows) else f"Lines are {len(cases)} cases"
    order = "" if are_numbers else " in the order of its values"
    caption = f"{lines}, coloured from yellow to violet by {escape(label)}{order}."
    return f'<h2>Curves</h2>{side_by_side(figures)}<p class="caption">{caption}</p>'
