"""Running one case of a study, in whatever process: its folder, its row."""

from __future__ import annotations

import shutil
import tomllib
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

from contiga.case.build import run
from contiga.case.part_cache import PartCache
from contiga.case.schema import Case, parse_case, tables_of
from contiga.errors import ContigaError, ContigaWarning
from contiga.report import write_report
from contiga.simulation.run import RunOptions
from contiga.studies.cases import StudyCase
from contiga.studies.quantities import Quantity
from contiga.studies.row import DONE, FAILED, LOST, Row, read_row

if TYPE_CHECKING:
    from contiga.simulation.result import Result

Progress = Callable[[int, int, int], Any]
CASES = "cases"
"""The folder in that of a study which has one for each case."""
_TURN = Lock()
"""Workers with several threads run one case at a time: what cases have in common is not theirs."""


@cache
def parts_of_process() -> PartCache:
    """Bodies and slaves this process has read: geometry is read once a worker."""
    return PartCache()


class Base(NamedTuple):
    """What all cases of a study have in common."""

    text: str
    """Of the base case."""
    path: str
    """Of its file: names of files in it start from there."""
    folder: str
    """Of the study."""
    quantities: dict[str, Quantity]
    """By column."""

    @property
    def units(self) -> dict[str, str]:
        """Of the quantities, by column; none where the base case names no units."""
        named = tomllib.loads(self.text).get("units") or {}
        units = (named.get("length", ""), named.get("mass", ""), named.get("time", ""))
        return {name: quantity.unit(units) for name, quantity in self.quantities.items()}

    @property
    def tables(self) -> dict[str, Any]:
        """Return the tables of the base case, with those of files that it includes."""
        return tomllib.loads(self.text) | tables_of(self.text, Path(self.path)).data

    def case(self, settings: dict[str, Any]) -> Case:
        """The base case with what one of the study sets."""
        return parse_case(self.text, self.path, set=settings)

    def folder_of(self, case: StudyCase) -> Path:
        """Of one case."""
        return Path(self.folder) / CASES / case.name


def row_of(base: Base, case: StudyCase) -> Row | None:
    """The row of a case that has been run before; None of one that is to be run."""
    row = read_row(base.folder_of(case))
    if row is None or row.status == LOST:
        return None
    return row if row.of_case(case.values, list(base.quantities)) else None


def run_one(base: Base, case: StudyCase, progress: Progress | None = None) -> Row:
    """Run a case into its folder and leave its row there; a row that is there already is taken.

    Nothing but an interruption gets out of it: a case that fails is a row with its message.
    """
    with _TURN:
        row = row_of(base, case)
        return _carried_out(base, case, progress) if row is None else row


def _carried_out(base: Base, case: StudyCase, progress: Progress | None) -> Row:
    """The row of a case that is run now."""
    folder, begun = base.folder_of(case), perf_counter()
    # What a killed process left there is none of a whole run.
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    status, message, collected = DONE, "", dict.fromkeys(base.quantities, float("nan"))
    try:
        result = _run(base.case(case.settings), folder, progress)
        collected = _collected(base, result)
        lacking = [name for name, value in collected.items() if value != value]
        message = f"has no {', '.join(lacking)}" if lacking else ""
    except ContigaError as error:
        status, message = FAILED, str(error)
    except Exception as error:
        status, message = FAILED, f"unexpected {type(error).__name__}: {error}".rstrip(": ")
    row = Row(case.number, status, message, case.values, collected, perf_counter() - begun)
    row.write(folder)
    return row


def _run(case: Case, folder: Path, progress: Progress | None) -> Result:
    """As `contiga.run`, but for the parts that cases have in common."""
    with warnings.catch_warnings():  # told in the summary, not on the stream of each worker
        warnings.simplefilter("ignore", ContigaWarning)
        how = RunOptions(progress=progress, on_finish=write_report)
        return run(case, folder, how, parts=parts_of_process())


def _collected(base: Base, result: Result) -> dict[str, float]:
    return {
        name: quantity.value(result.history, result.summary)
        for name, quantity in base.quantities.items()
    }
