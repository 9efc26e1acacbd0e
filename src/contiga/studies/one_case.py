"""One case of a study, run in any process: its folder and its row."""

from __future__ import annotations

import shutil
import tomllib
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any, NamedTuple

from contiga.case.build import run
from contiga.case.part_cache import PartCache
from contiga.case.schema import Case, parse_case, tables_of
from contiga.errors import ContigaError, ContigaWarning
from contiga.report import write_report
from contiga.simulation.run import RunOptions
from contiga.studies.cases import StudyCase
from contiga.studies.quantities import Quantity
from contiga.studies.row import DONE, FAILED, LOST, Row, read_row

Progress = Callable[[int, int, int], Any]
CASES = "cases"
"""Subfolder of the folder of a study, with a folder for each case."""
_ONE_AT_A_TIME = Lock()
"""Lock of a worker with several threads, which runs one case at a time: its parts are shared."""


@cache
def parts_of_process() -> PartCache:
    """Return the cache of bodies and slaves of this process: a worker reads geometry once."""
    return PartCache()


class Base(NamedTuple):
    """The common data of all cases of a study."""

    text: str
    """Text of the base case."""
    path: str
    """Path of its file, from which its file names start."""
    folder: str
    """Folder of the study."""
    quantities: dict[str, Quantity]
    """Collected quantities, by column."""

    @property
    def units(self) -> dict[str, str]:
        """The units of the quantities, by column; empty if the base case names no units."""
        named = tomllib.loads(self.text).get("units") or {}
        units = (named.get("length", ""), named.get("mass", ""), named.get("time", ""))
        return {name: quantity.unit(units) for name, quantity in self.quantities.items()}

    @property
    def tables(self) -> dict[str, Any]:
        """The tables of the base case; those with parts in included files are merged with them."""
        return tomllib.loads(self.text) | tables_of(self.text, Path(self.path)).data

    def case(self, settings: dict[str, Any]) -> Case:
        """Return the base case with the settings of one case."""
        return parse_case(self.text, self.path, set=settings)

    def folder_of(self, case: StudyCase) -> Path:
        """Return the folder of one case."""
        return Path(self.folder) / CASES / case.name


def row_of(base: Base, case: StudyCase) -> Row | None:
    """Return the row of a case in its folder; None if the case is to be run.

    A row is not that of the case if its worker was lost, or values or quantities differ.
    """
    row = read_row(base.folder_of(case))
    if row is None or row.status == LOST:
        return None
    return row if row.of_case(case.values, list(base.quantities)) else None


def run_one(base: Base, case: StudyCase, progress: Progress | None = None) -> Row:
    """Run a case into its folder as `contiga.run` does; write its row there, and return it.

    If there is a row already (`row_of`), it is returned instead; else the folder is emptied first.
    Any error of the case becomes a row with its message, and quantities that it does not have are
    NaN. Warnings of the run are in its summary only.
    """
    with _ONE_AT_A_TIME:
        row = row_of(base, case)
        if row is not None:
            return row
        folder, start = base.folder_of(case), perf_counter()
        # A killed process may have left part of a run there.
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        status, message, collected = DONE, "", dict.fromkeys(base.quantities, float("nan"))
        try:
            checked = base.case(case.settings)
            options = RunOptions(progress=progress, on_finish=write_report)
            with warnings.catch_warnings():  # not on the stream of each worker
                warnings.simplefilter("ignore", ContigaWarning)
                result = run(checked, folder, options, parts=parts_of_process())
            collected = {
                name: quantity.value(result.history, result.summary)
                for name, quantity in base.quantities.items()
            }
            missing = [name for name, value in collected.items() if value != value]
            message = f"has no {', '.join(missing)}" if missing else ""
        except ContigaError as error:
            status, message = FAILED, str(error)
        except Exception as error:
            status, message = FAILED, f"unexpected {type(error).__name__}: {error}".rstrip(": ")
        seconds = perf_counter() - start
        row = Row(case.number, status, message, case.values, collected, seconds)
        row.write(folder)
        return row
