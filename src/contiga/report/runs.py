"""Several runs beside each other: in the units of the first, each with a name of its own."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from contiga.errors import InputError
from contiga.report.run_folder import Run, read_run
from contiga.report.style import number

SEPARATOR = " · "
"""Between the name of a case and its values."""
_ROW = "row.json"
"""What a study leaves in the folder of each case."""
_VALUES = 3
"""Values of a case that are in its name."""


class Named(NamedTuple):
    """A run and what it is called."""

    run: Run
    name: str


def read_runs(folders: Sequence[str | Path]) -> list[Named]:
    """Read runs, the later ones in the units of the first.

    They are called by the names of their folders, by their paths where two names are the same.

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
        if bool(all(run.own_units)) != bool(all(first.own_units)):
            raise InputError(
                "one run has units and another has none, so nothing can be converted",
                where=str(folder),
                found=", ".join(filter(None, run.own_units)) or "none",
                allowed=", ".join(filter(None, first.own_units)) or "none",
            )
        runs.append(run)
    return [Named(run, name) for run, name in zip(runs, names_of(runs), strict=True)]


def names_of(runs: Sequence[Run]) -> list[str]:
    """What runs are called: their folders' names, with the values of a case of a study; their
    paths where two names are the same."""
    paths = [run.folder.resolve() for run in runs]
    names = [SEPARATOR.join([path.name, *_values_of(path)]) for path in paths]
    return names if len(set(names)) == len(names) else [str(path) for path in paths]


def _values_of(folder: Path) -> list[str]:
    """Values of the variables of a case of a study, the first of them; none of another run."""
    try:
        values = json.loads((folder / _ROW).read_text(encoding="utf-8"))["values"]
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return [
        f"{key.rpartition('.')[2]} {number(value) if isinstance(value, int | float) else value}"
        for key, value in list(values.items())[:_VALUES]
    ]
