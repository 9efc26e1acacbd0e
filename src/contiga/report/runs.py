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
    """Read runs, the later ones in the units of the first.

    Their names are those of `names_of`.

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

    Where two names are the same, all are paths.
    """
    paths = [run.folder.resolve() for run in runs]
    names = [SEPARATOR.join([path.name, *_study_values(path)]) for path in paths]
    return names if len(set(names)) == len(names) else [str(path) for path in paths]


def _study_values(folder: Path) -> list[str]:
    """Return the first values of a case of a study as texts; empty for any other run."""
    try:
        values = json.loads((folder / _ROW).read_text(encoding="utf-8"))["values"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [
        f"{key.rpartition('.')[2]} {number(value) if isinstance(value, int | float) else value}"
        for key, value in list(values.items())[:_MAX_VALUES]
    ]
