"""The page of a comparison of runs."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from contiga.io.channels import shown
from contiga.io.out.files import check_suffix, write_text
from contiga.io.units import with_unit
from contiga.report import require_packages
from contiga.report.comparison import Comparison, Values
from contiga.report.curves import Curve, channels_of, curve_figure, curves_of
from contiga.report.figure import embedded, plotly_script, side_by_side
from contiga.report.html_tables import STAGES
from contiga.report.lines import PLOT_CONFIG
from contiga.report.references import (
    has_channels,
    rated,
    ratings_table,
    references_of,
)
from contiga.report.style import LINES, number, swatch
from contiga.report.style import page as styled

_PANELS = {
    "force": "force",
    "max_penetration": "deepest penetration",
    "area": "contact area",
    "work": "work on the contact",
    "a": "acceleration",
    "filtered_a": "acceleration, filtered",
    "x": "along x",
    "y": "along y",
    "z": "along z",
    "kinetic": "kinetic energy",
    "total": "total energy",
    "error": "energy balance error",
}
"""Columns drawn over time, and the labels of their axes."""
_MAX_CHARACTERS = 60
"""Length at which the value of a setting is cut."""
_MAX_UPRIGHT = 5
"""Largest number of runs whose tables fit an upright page of paper."""
_MAX_NAMED = 3
"""Largest number of runs that each figure names; the list at the head of the page names more."""


def write_comparison(comparison: Comparison, path: str | Path) -> Path:
    """Write the page of a comparison, one file that reads offline; whole or not at all.

    Raises
    ------
    FileError
        The suffix is not .html.
    OutputError
        The page cannot be written.
    MissingPackageError
        plotly or matplotlib is not installed.
    """
    check_suffix(path, ".html")
    require_packages("a comparison")
    write_text(Path(path), page_of(comparison))
    return Path(path)


def page_of(comparison: Comparison) -> str:
    """Return the page as one text of HTML."""
    names, units = comparison.names, comparison.runs[0].units
    span = f"t = {number(comparison.span[0])} to {number(comparison.span[1])} {units.time}".strip()
    title = " and ".join(names) if len(names) == 2 else f"{len(names)} runs"
    run_rows = ""
    for k, (run, name) in enumerate(comparison.named):
        text = escape(str(run.summary.get("title") or "a run"))
        own, new = run.own_units, (run.units.length, run.units.mass, run.units.time)
        if all(own) and own != new:
            text += f" · converted from {escape(', '.join(own))} to {escape(', '.join(new))}"
        colour = swatch(LINES[k % len(LINES)])
        run_rows += f"<tr><td>{colour}{escape(name)}</td><td>{text}</td></tr>"
    settings = "<p>None.</p>"
    if comparison.settings:
        rows = ((key, *map(shortened, values)) for key, values in comparison.settings.items())
        settings = _table(("Key", *comparison.short_names), rows, numbers=0)
    shares = comparison.energies.get("relative", ())
    energies = {
        "share of the largest energy [%]": tuple(v and 100.0 * v for v in shares),
        with_unit("largest energy", units.energy): comparison.energies.get("most", ()),
    }
    words = {"total": "In all", "steps": "Steps", **STAGES}
    timings = {
        with_unit(words.get(key, key), "" if key == "steps" else "s"): values
        for key, values in comparison.timings.items()
    }
    parts = [
        '<div class="maker"><b>contiga</b> · comparison of runs</div>'
        f'<h1>{escape(title)}</h1><p class="under">common time {escape(span)}</p>',
        '<div class="wide"><table><thead><tr><th>Run</th><th>Title</th></tr></thead>'
        f"<tbody>{run_rows}</tbody></table></div>",
        _section("Settings that differ", settings),
        _section("Criteria", _values_table(comparison, criteria_with_units(comparison))),
        f"<h2>Curves</h2>{_curves(comparison)}",
        _section("Histories", _differences(comparison)),
        _section(
            "Energy balance error",
            _values_table(comparison, {label: row for label, row in energies.items() if row}),
        ),
        _section("Time taken", _values_table(comparison, timings)),
    ]
    text = "\n".join(parts)
    if len(comparison.runs) > _MAX_UPRIGHT:
        text = f'<div class="many">{text}</div>'
    return styled(title, text, script=plotly_script())


def _section(title: str, table: str) -> str:
    return f'<h2>{title}</h2><div class="wide">{table}</div>' if table else ""


def shortened(value: Any) -> str:
    """Return the value of a setting as text, cut after 60 characters; a dash for None."""
    text = "–" if value is None else str(value)
    return text if len(text) <= _MAX_CHARACTERS else f"{text[:_MAX_CHARACTERS]}…"


def peaks_of(comparison: Comparison, name: str) -> tuple[list[float], float, str]:
    """Return the peaks of a column in each run, its largest difference, and their unit as shown."""
    d = comparison.differences[name]
    channel = shown(
        name, np.array([*d.peaks, d.largest]), comparison.runs[0].summary.get("units") or {}
    )
    *peaks, largest = channel.values.tolist()
    return peaks, largest, channel.unit


def _differences(comparison: Comparison) -> str:
    """Return the table of the columns that differ, and a sentence on those that it leaves out.

    These are equal columns, rounding (`Comparison.noise`), wall times, and those that a run lacks.
    """
    names, two = comparison.short_names, len(comparison.runs) == 2
    heads = ("Column", *(f"Peak of {name}" for name in names))
    heads += ("Largest difference" if two else f"Largest difference from {names[0]}",)
    heads += (with_unit("At t", comparison.runs[0].units.time), "Share")
    rows = []
    for name, d in comparison.differences.items():
        if d.largest > 0.0 and name not in comparison.noise and not name.endswith(".wall_time"):
            peaks, largest, unit = peaks_of(comparison, name)
            share = f"{number(100.0 * d.relative, 3)} %"
            cells = (*map(number, peaks), number(largest), number(d.at), share)
            rows.append((with_unit(name, unit), *cells))
    table = _table(heads, rows, numbers=len(heads) - 1)
    n_equal = sum(d.largest == 0.0 for d in comparison.differences.values())
    n_noise = sum(comparison.differences[name].largest > 0.0 for name in comparison.noise)
    facts = [f"{n_equal} of {len(comparison.differences)} columns are equal at all times"]
    if n_noise:
        facts.append(f"{n_noise} are rounding in every run and are left out")
    facts += [
        f"only in {escape(name)}: {escape(', '.join(columns))}"
        if two
        else f"not all runs have these columns of {escape(name)}: {escape(', '.join(columns))}"
        for name, columns in zip(names, comparison.only, strict=True)
        if columns
    ]
    return f'{table}<p class="caption">{"; ".join(facts)}.</p>'


def _curves(comparison: Comparison) -> str:
    """Return figures of `_PANELS` over time and of `curves_of` all runs, and a table of ratings.

    A figure has a line for each run; columns that are rounding have none. Tests of all runs are
    drawn, each once, if the first run has their channels; an earlier run's goes before one of the
    same name. Ratings of each run follow.
    """
    first = comparison.runs[0]
    references = {
        (reference.channel, reference.x, reference.name): reference
        for run in reversed(comparison.runs)
        for reference in references_of(run)
        if has_channels(first, reference)
    }.values()
    tests = [reference.moved(first) for reference in references]
    labels: dict[Curve, str] = {}
    for name in comparison.differences:
        owner, _, column = name.rpartition(".")
        if name not in comparison.noise and column in _PANELS:
            labels[Curve("time", (name,))] = f"{owner}: {_PANELS[column]}"
    curves = dict.fromkeys([*labels, *(c for run in comparison.runs for c in curves_of(run))])
    figures: list[str] = []
    for curve in curves:
        if not any(channels_of(run, curve) for run in comparison.runs):
            continue
        figure = curve_figure(comparison.named, curve, tests, None, label=labels.get(curve))
        if len(comparison.runs) > _MAX_NAMED and len(curve.y) == 1:
            figure.layout["showlegend"] = False
        figures.append(embedded(figure, f"both-{len(figures)}", PLOT_CONFIG))
    ratings = [
        rated(run, reference, name)
        for reference in references
        for run, name in comparison.named
        if has_channels(run, reference)
    ]
    return side_by_side(figures) + ratings_table(ratings, first.units.time)


def criteria_with_units(comparison: Comparison) -> dict[str, Values]:
    """Return the values of criteria in each run, by ``<sensor>: <criterion> [<unit>]``."""
    units = {
        f"{sensor}: {name}": str(result.get("unit") or "")
        for run in comparison.runs
        for sensor, facts in run.summary_part("sensors").items()
        for name, result in facts["criteria"].items()
    }
    return {
        with_unit(name, units.get(name, "")): values for name, values in comparison.criteria.items()
    }


def _values_table(comparison: Comparison, values: dict[str, Values]) -> str:
    """Return a table of the numbers of each run; for two runs, with the change from the first.

    The text is empty without values.
    """
    if not values:
        return ""
    two = len(comparison.runs) == 2
    rows = []
    for label, numbers in values.items():
        cells = ["–" if value is None else number(value) for value in numbers]
        if two:
            a, b = numbers
            has_change = a is not None and b is not None and a != 0.0
            cells.append(f"{100.0 * (b - a) / abs(a):+.3g} %" if has_change else "–")
        rows.append((label, *cells))
    heads = ("", *comparison.short_names, *(("Change",) if two else ()))
    return _table(heads, rows, numbers=len(heads) - 1)


def _table(heads: Iterable[str], rows: Iterable[tuple[str, ...]], *, numbers: int) -> str:
    """Return a table of texts whose last `numbers` columns are numbers; empty without rows."""
    heads = tuple(heads)
    kinds = ("",) * (len(heads) - numbers) + (' class="number"',) * numbers
    head = "".join(f"<th{k}>{escape(h)}</th>" for k, h in zip(kinds, heads, strict=True))
    body = "".join(
        "<tr>"
        + "".join(f"<td{k}>{escape(cell)}</td>" for k, cell in zip(kinds, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>" if body else ""
