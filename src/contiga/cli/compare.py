"""``contiga compare DIR DIR …``: runs beside each other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.errors import InputError
from contiga.io.out.stored import SUMMARY

if TYPE_CHECKING:
    from contiga.report.comparison import Comparison

_MOST = 12
"""Settings printed at most."""
_TELLING = ("force", "max_penetration", "a", "filtered_a", "total", "error")
"""Columns printed, of whatever has them."""


def compare(
    folders: Annotated[
        list[Path],
        typer.Argument(
            metavar="DIR…", help="Output folders of 2 to 20 runs, or the folder of a study."
        ),
    ],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Page to write: .html, reads offline.")
    ] = None,
) -> None:
    """Set runs beside each other: settings, histories, peaks, criteria, energies, times."""
    from contiga.report.comparison import MOST
    from contiga.report.comparison import compare as compared
    from contiga.report.comparison_page import write_comparison

    runs = [run for folder in folders for run in runs_in(folder)]
    if not 2 <= len(runs) <= MOST:
        raise InputError(
            "runs to be compared",
            found=len(runs),
            allowed=f"2 to {MOST}",
            remedy=f"Name the cases that are meant, such as {runs[0]}"
            if len(runs) > MOST
            else None,
        )
    comparison = compared(*runs)
    for line in _lines(comparison):
        print(line)
    if out is not None:
        print(f"page: {write_comparison(comparison, out)}")


def runs_in(folder: Path) -> list[Path]:
    """The folders of the cases of a study; a folder that is none of a study is a run's own."""
    from contiga.studies.folder import MANIFEST
    from contiga.studies.one_case import CASES

    if not (folder / MANIFEST).is_file():
        return [folder]
    return sorted(path.parent for path in (folder / CASES).glob(f"*/{SUMMARY}"))


def _lines(comparison: Comparison) -> Iterator[str]:
    """The essentials."""
    from contiga.report.comparison_page import criteria_with_units, in_short, peaks_of
    from contiga.report.style import number

    if len(comparison.runs) > 2:
        yield f"runs: {' → '.join(comparison.names)}"
    first_settings = list(comparison.settings.items())[:_MOST]
    for key, values in first_settings:
        yield f"{key}: {' → '.join(map(in_short, values))}"
    if len(comparison.settings) > len(first_settings):
        yield f"and {len(comparison.settings) - len(first_settings)} more settings"
    if not comparison.settings:
        yield "the cases say the same"
    for name, d in comparison.differences.items():
        if name.rpartition(".")[2] in _TELLING and name not in comparison.noise:
            share = f"{100.0 * d.relative:.3g} %" if d.largest > 0.0 else "none"
            peaks, _, unit = peaks_of(comparison, name)
            told = " ".join([" → ".join(map(number, peaks)), unit]).rstrip()
            time = f"{number(d.at)} {comparison.runs[0].units.time}".rstrip()
            when = f" at t = {time}" if d.largest > 0.0 else ""
            yield f"{name}: peak {told}, largest difference {share}{when}"
    for name, values in criteria_with_units(comparison).items():
        yield f"{name} {' → '.join('–' if v is None else number(v) for v in values)}"
    for words, key in (("steps", "steps"), ("seconds", "total")):
        values = comparison.timings.get(key, (None,))
        if None not in values:
            yield f"{words}: {' → '.join(map(number, values))}"
