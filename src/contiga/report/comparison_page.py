"""The page that shows two runs beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from html import escape
from pathlib import Path
from typing import Any

from contiga.io.out.files import write_text
from contiga.records import FloatArray
from contiga.report import require_packages
from contiga.report.comparison import Comparison, Pair, columns_of
from contiga.report.figure import Figure, embedded, plotly_script, side_by_side
from contiga.report.html_tables import STAGES
from contiga.report.lines import PLOT_CONFIG, add_line, finish, largest, with_unit
from contiga.report.run_folder import Run
from contiga.report.style import LINES, number
from contiga.report.style import page as styled

_PANELS = (
    ("force", "Force", "force"),
    ("max_penetration", "Deepest penetration", "length"),
    ("area", "Contact area", "area"),
    ("work", "Work on the contact", "energy"),
    ("a", "Acceleration", "acceleration"),
    ("filtered_a", "Acceleration, filtered", "acceleration"),
    ("x", "Centre along x", "length"),
    ("y", "Centre along y", "length"),
    ("z", "Centre along z", "length"),
    ("kinetic", "Kinetic energy", "energy"),
    ("total", "Total energy", "energy"),
    ("error", "Energy balance error", "energy"),
)
"""Columns that are drawn: name, label, and what unit they have."""
_LONGEST = 60


def write_comparison(comparison: Comparison, path: str | Path) -> Path:
    """Write the page of a comparison, one file that reads offline; whole or not at all.

    Raises
    ------
    OutputError
        It cannot be written.
    MissingPackageError
        A package that it is drawn with is not installed.
    """
    require_packages("a comparison")
    write_text(Path(path), page_of(comparison))
    return Path(path)


def names_of(comparison: Comparison) -> tuple[str, str]:
    """What the two runs are called: the names of their folders, where these tell them apart."""
    a, b = (folder.resolve() for folder in comparison.folders)
    return (a.name, b.name) if a.name != b.name else (str(a), str(b))


def page_of(comparison: Comparison) -> str:
    """The page as one text."""
    one, two = names_of(comparison)
    unit = comparison.runs[0].units.time
    span = f"t = {number(comparison.span[0])} to {number(comparison.span[1])} {unit}".strip()
    titles = " · ".join(
        f"{escape(name)}: {escape(str(run.summary.get('title') or 'a run'))}"
        for name, run in zip((one, two), comparison.runs, strict=True)
    )
    parts = [
        '<div class="maker"><b>contiga</b> · two runs beside each other</div>'
        f"<h1>{escape(one)} and {escape(two)}</h1>"
        f'<p class="under">{titles} · in common {escape(span)}</p>',
        _section("Settings that differ", _settings(comparison)),
        _section("Histories", _differences(comparison)),
        side_by_side(_drawn(comparison)),
        _section("Criteria", _pairs(comparison, comparison.criteria)),
        _section("Energy balance error", _pairs(comparison, comparison.energies)),
        _section("Time taken", _timings(comparison)),
    ]
    return styled(f"{one} and {two}", "\n".join(parts), script=plotly_script())


def _section(title: str, table: str) -> str:
    return f'<h2>{title}</h2><div class="wide">{table}</div>' if table else ""


def _settings(comparison: Comparison) -> str:
    if not comparison.settings:
        return "<p>None.</p>"
    rows = ((key, *map(in_short, pair)) for key, pair in comparison.settings.items())
    return _table(("Key", *names_of(comparison)), rows, numbers=0)


def in_short(value: Any) -> str:
    """A value of a case, cut where it is long."""
    text = "–" if value is None else str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"


def _differences(comparison: Comparison) -> str:
    one, two = names_of(comparison)
    heads = ("Column", f"Peak of {one}", f"Peak of {two}", "Largest difference", "At", "Share")
    rows = (
        (
            name,
            *map(number, d.peaks),
            number(d.largest),
            number(d.at),
            f"{number(100.0 * d.relative, 3)} %",
        )
        for name, d in comparison.differences.items()
        if d.largest > 0.0 and not name.endswith(".wall_time")
    )
    table = _table(heads, rows, numbers=5)
    same = sum(d.largest == 0.0 for d in comparison.differences.values())
    only = [
        f"only in {escape(name)}: {escape(', '.join(columns))}"
        for name, columns in zip((one, two), comparison.only, strict=True)
        if columns
    ]
    facts = [f"{same} of {len(comparison.differences)} columns are equal at all times", *only]
    return f'{table}<p class="caption">{"; ".join(facts)}.</p>'


def _drawn(comparison: Comparison) -> Iterator[str]:
    """Figures of the columns that both have, one line a run."""
    columns = tuple(columns_of(run) for run in comparison.runs)
    shown = 0
    for label in comparison.differences:
        owner, _, name = label.rpartition(".")
        panel = next((p for p in _PANELS if p[0] == name), None)
        pair = columns[0][label], columns[1][label]
        if panel is None or max(map(largest, pair)) == 0.0:
            continue
        unit = getattr(comparison.runs[0].units, panel[2])
        figure = _figure(comparison, pair, (f"{owner}: {panel[1].lower()}", unit))
        yield embedded(figure, f"both-{shown}", PLOT_CONFIG)
        shown += 1


def _figure(
    comparison: Comparison, pair: tuple[FloatArray, FloatArray], labels: tuple[str, str]
) -> Figure:
    figure = Figure()
    looks = ({"width": 2.2}, {"width": 1.6, "dash": "dash"})
    runs: Iterable[tuple[Run, str, FloatArray, dict[str, Any], str]] = zip(
        comparison.runs, names_of(comparison), pair, looks, LINES, strict=False
    )
    for run, name, values, look, colour in runs:
        add_line(figure, run.times, values, name, labels[1], color=colour, **look)
    finish(figure, comparison.runs[0], with_unit(*labels), None)
    return figure


def _pairs(comparison: Comparison, pairs: dict[str, Pair]) -> str:
    if not pairs:
        return ""
    rows = ((key, *map(_number, pair), _change(pair)) for key, pair in pairs.items())
    return _table(("", *names_of(comparison), "Change"), rows, numbers=3)


def _timings(comparison: Comparison) -> str:
    words = {"total": "Seconds in all", "steps": "Steps", **STAGES}
    return _pairs(
        comparison, {words.get(key, key): pair for key, pair in comparison.timings.items()}
    )


def _number(value: float | None) -> str:
    return "–" if value is None else number(value)


def _change(pair: Pair) -> str:
    one, two = pair
    if one is None or two is None or one == 0.0:
        return "–"
    return f"{100.0 * (two - one) / abs(one):+.3g} %"


def _table(heads: Iterable[str], rows: Iterable[tuple[str, ...]], *, numbers: int) -> str:
    """A table whose last `numbers` columns are numbers."""
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
