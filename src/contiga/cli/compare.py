"""``contiga compare A B``: two runs beside each other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from contiga.report.comparison import Comparison

_MOST = 12
"""Settings printed at most."""
_TELLING = ("force", "max_penetration", "a", "filtered_a", "total", "error")
"""Columns printed, of whatever has them."""


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="Output folder of a run.")],
    b: Annotated[Path, typer.Argument(metavar="B", help="Output folder of another.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Page to write: .html, reads offline.")
    ] = None,
) -> None:
    """Set two runs beside each other: settings, histories, peaks, criteria, energies, times."""
    from contiga.report.comparison import compare as compared
    from contiga.report.comparison_page import write_comparison

    comparison = compared(a, b)
    for line in _lines(comparison):
        print(line)
    if out is not None:
        print(f"page: {write_comparison(comparison, out)}")


def _lines(comparison: Comparison) -> Iterator[str]:
    """The essentials."""
    from contiga.report.comparison_page import in_short
    from contiga.report.style import number

    first_settings = list(comparison.settings.items())[:_MOST]
    for key, (one, two) in first_settings:
        yield f"{key}: {in_short(one)} → {in_short(two)}"
    if len(comparison.settings) > len(first_settings):
        yield f"and {len(comparison.settings) - len(first_settings)} more settings"
    if not comparison.settings:
        yield "the cases say the same"
    for name, d in comparison.differences.items():
        if name.rpartition(".")[2] in _TELLING and max(map(abs, d.peaks)) > 0.0:
            share = f"{100.0 * d.relative:.3g} %" if d.largest > 0.0 else "none"
            peaks = " → ".join(map(number, d.peaks))
            when = f" at t = {number(d.at)}" if d.largest > 0.0 else ""
            yield f"{name}: peak {peaks}, largest difference {share}{when}"
    for name, (one, two) in comparison.criteria.items():
        values = " → ".join("–" if value is None else number(value) for value in (one, two))
        yield f"{name} {values}"
    steps, total = (comparison.timings.get(key, (None, None)) for key in ("steps", "total"))
    for words, pair in (("steps", steps), ("seconds", total)):
        if None not in pair:
            yield f"{words}: {' → '.join(number(value) for value in pair)}"
