"""``contiga compare DIR DIR …``: a comparison of runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.errors import InputError
from contiga.io.out.stored import SUMMARY

if TYPE_CHECKING:
    from contiga.report.comparison import Comparison

_MAX_SETTINGS = 12
"""Largest number of settings that are printed."""
_PRINTED_COLUMNS = ("force", "max_penetration", "a", "filtered_a", "total", "error")
"""Columns that are printed, of each contact, sensor and the system."""


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
    """Compare runs: settings, histories, peaks, criteria, energies, times."""
    from contiga.io.out.files import check_suffix
    from contiga.report.comparison import MAX_RUNS
    from contiga.report.comparison import compare as compared
    from contiga.report.comparison_page import write_comparison

    if out is not None:
        check_suffix(out, ".html")
    runs = [run for folder in folders for run in runs_in(folder)]
    if not 2 <= len(runs) <= MAX_RUNS:
        raise InputError(
            "the wrong number of runs",
            where="DIR",
            found=len(runs),
            allowed=f"2 to {MAX_RUNS}",
            remedy=f"Name the cases to compare, such as {runs[0]}"
            if len(runs) > MAX_RUNS
            else None,
        )
    comparison = compared(*runs)
    _print_comparison(comparison)
    if out is not None:
        print(f"page: {write_comparison(comparison, out)}")


def runs_in(folder: Path) -> list[Path]:
    """Return the folders of the cases of a study that have run, in the order of their names.

    A folder without the manifest of a study is returned itself.
    """
    from contiga.studies.folder import MANIFEST
    from contiga.studies.one_case import CASES

    if not (folder / MANIFEST).is_file():
        return [folder]
    return sorted(path.parent for path in (folder / CASES).glob(f"*/{SUMMARY}"))


def _print_comparison(comparison: Comparison) -> None:
    """Print settings that differ, peaks and largest differences, criteria, steps and seconds.

    At most 12 settings are printed, and histories only of the main columns, without those that
    differ by noise alone.
    """
    from contiga.report.comparison_page import criteria_with_units, peaks_of, shortened
    from contiga.report.style import number

    if len(comparison.runs) > 2:
        print(f"runs: {' → '.join(comparison.names)}")
    first_settings = list(comparison.settings.items())[:_MAX_SETTINGS]
    for key, values in first_settings:
        print(f"{key}: {' → '.join(map(shortened, values))}")
    if len(comparison.settings) > len(first_settings):
        print(f"and {len(comparison.settings) - len(first_settings)} more settings")
    if not comparison.settings:
        print("no setting differs")
    for name, d in comparison.differences.items():
        if name.rpartition(".")[2] in _PRINTED_COLUMNS and name not in comparison.noise:
            share = f"{100.0 * d.relative:.3g} %" if d.largest > 0.0 else "none"
            peaks, _, unit = peaks_of(comparison, name)
            peak_text = " ".join([" → ".join(map(number, peaks)), unit]).rstrip()
            time = f"{number(d.at)} {comparison.runs[0].units.time}".rstrip()
            time = f" at t = {time}" if d.largest > 0.0 else ""
            print(f"{name}: peak {peak_text}, largest difference {share}{time}")
    for name, results in criteria_with_units(comparison).items():
        print(f"{name}: {' → '.join('–' if v is None else number(v) for v in results)}")
    for label, key in (("steps", "steps"), ("seconds", "total")):
        times = comparison.timings.get(key, (None,))
        if None not in times:
            print(f"{label}: {' → '.join(map(number, times))}")
