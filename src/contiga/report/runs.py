"""Several runs, in the units of the first, each with a name of its own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from contiga.errors import InputError
from contiga.report.run_folder import Run, read_run
from contiga.report.style import number

SEPARATOR = " · "
"""Separator of the name of a case and its values."""
_ROW = "row.json"
"""File that a study writes into the folder of each case."""
_MAX_VALUES = 3
"""Largest number of values of a case in its name."""


class Named(NamedTuple):
    """A run with its name."""

    run: Run
    name: str


def read_runs(folders: Sequence[str | Path]) -> list[Named]:
    """Read runs, the later ones converted to the units of the first, and name them (`names_of`).

    Parameters
    ----------
    folders : output folders of runs, one or more

    Raises
    ------
    FileError
        A folder is not that of a run.
    InputError
        Some have units and some have none.
    """
    first = read_run(Path(folders[0]))
    runs = [first]
    for folder in map(Path, folders[1:]):
        run = read_run(folder, first.own_units if all(first.own_units) else None)
        if all(run.own_units) != all(first.own_units):
            raise InputError(
                "one run has units and another has none, so nothing can be converted",
                where=str(folder),
                found=", ".join(filter(None, run.own_units)) or "none",
                allowed=", ".join(filter(None, first.own_units)) or "none",
            )
        runs.append(run)
    return [Named(run, name) for run, name in zip(runs, names_of(runs), strict=True)]


def names_of(runs: Sequence[Run]) -> list[str]:
    """Return the names of runs: those of their folders, with the values of a case of a study.

    At most three values stand in a name. If two names are the same, all names are absolute paths.
    """
    paths = [run.folder.resolve() for run in runs]
    names = []
    for path in paths:
        try:
            values = json.loads((path / _ROW).read_text(encoding="utf-8"))["values"]
            values = list(values.items())[:_MAX_VALUES]
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            values = []  # a run that is no case of a study
        texts = (
            f"{key.rpartition('.')[2]} {number(value) if isinstance(value, int | float) else value}"
            for key, value in values
        )
        names.append(SEPARATOR.join([path.name, *texts]))
    return names if len(set(names)) == len(names) else [str(path) for path in paths]
