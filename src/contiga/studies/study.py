"""A whole study: from its specification to the folder with its table and its page."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contiga.case.build import build
from contiga.case.columns import columns_of_case, criteria_of_case
from contiga.case.problems import errors_at
from contiga.case.schema import Case, load_case
from contiga.case.settings import plain
from contiga.case.toml import resolved_toml
from contiga.display import Displayed, Facts
from contiga.errors import CaseError, MissingPackageError
from contiga.extras import require
from contiga.io.naming import closest
from contiga.report import require_packages
from contiga.studies.cases import StudyCase, case_of, cases_of, check_keys, listed_values
from contiga.studies.engines import cores, engine_for
from contiga.studies.figure import plot_table
from contiga.studies.folder import PAGE, StudyFolder
from contiga.studies.one_case import Base, parts_of_process, row_of
from contiga.studies.optimise import best_of, optimised
from contiga.studies.page import write_page
from contiga.studies.row import DONE, Row
from contiga.studies.spec import StudySpec, study_of
from contiga.studies.table import Table
from contiga.studies.targets import targets_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Progress = Callable[[int, int, str], Any]
"""Callback with the number of finished cases, of all cases, and a message about them."""
_MAX_CHECKED = 200
"""Largest number of cases checked before any is run: errors of others become rows."""


@dataclass(frozen=True, eq=False, repr=False)
class Study(Displayed):
    """The results of a study. See `contiga.study`."""

    out: Path
    """Its folder: ``table.h5``, ``table.csv``, ``study.html``, and ``cases`` with their folders."""
    table: Table
    """Columns by name, a row for each case, in the order of their numbers."""
    rows: tuple[Row, ...]
    """Rows of all cases as records, with the seconds that each case took."""
    best: Row | None
    """The best case within the limits, if the study has a goal."""
    kept: object = None
    """Owner of a temporary folder, which is removed with the study."""

    @property
    def failed(self) -> tuple[Row, ...]:
        """The rows of the cases that failed."""
        return tuple(row for row in self.rows if row.status != DONE)

    @property
    def page(self) -> Path:
        """The page of the study, which reads offline."""
        return self.out / PAGE

    def folder_of(self, number: int) -> Path:
        """Return the output folder of a case, by its number.

        Neither folder nor case need exist.
        """
        return self.out / "cases" / f"{number:04d}"

    def to_pandas(self) -> DataFrame:
        """Return the table of cases as a pandas DataFrame, indexed by case number.

        Raises
        ------
        MissingPackageError
            pandas is not installed.
        """
        return self.table.to_pandas()

    def plot(self, *, columns: Sequence[str] | None = None) -> Figure:
        """Return a figure of the quantities over the only variable, else over the cases.

        A variable of texts is not drawn over. At most nine quantities have a panel. The figure is
        drawn with matplotlib, without a window; a notebook shows it.

        Parameters
        ----------
        columns : names of the table to draw in place of all quantities

        Raises
        ------
        InputError
            A column that the table does not have, or of text.
        MissingPackageError
            matplotlib is not installed.
        """
        return plot_table("Study.plot", self.table, columns)

    def _picture(self) -> bytes | None:
        try:
            figure = plot_table("a picture", self.table)
        except MissingPackageError:
            return None
        return figure.png(dpi=72)

    def _facts(self) -> Facts:
        return [
            ("cases", len(self.rows)),
            ("failed", len(self.failed)),
            ("variables", len(self.table.variables)),
            ("best", "none" if self.best is None else self.best.number),
            ("folder", self.out),
        ]


def study(
    base: Case | str | Path,
    variables: Mapping[str, Any],
    collect: Sequence[str] | Mapping[str, str],
    *,
    out: str | Path | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    resume: bool = False,
    **more: Any,
) -> Study:
    """Run many variants of a case, in parallel.

    Returned are their table, their rows and, with a goal, the best row; a page is written, too. A
    case that fails is a row with its message. In a script the call stands under
    ``if __name__ == "__main__":``.

    Parameters
    ----------
    base : a `Case`, with the keys of the case.toml that a run writes, or the path of a file
    variables : what differs, by key of the case: a list of values, or what a ``[[variable]]`` of a
        study file says, ``{"low": 40.0, "high": 80.0, "count": 5}``
    collect : quantities of each case, ``["head_cg.HIC15", "max(force)"]``, or by column
    out : folder of the study; None keeps one for as long as the `Study` is kept
    scheduler : address of a running Dask scheduler; processes of this machine if omitted
    workers : how many of these, one a core if omitted; 0 runs the cases in this process
    resume : run what is missing in `out`
    more : any other key of a study file (``sample``, ``rule``, ``goal``, …), and ``progress``, a
        function called with the finished cases, the number of all cases, and a message

    Raises
    ------
    InputError, MissingPackageError
        The study, its base case or the folder cannot be used; nothing has been run.
    RunError
        The cluster was lost; the rows so far are in the folder.

    Examples
    --------
    >>> import contiga as cg
    >>> quick = {"time.end": 0.2, "output": {"report": False, "formats": ["csv"]}}
    >>> found = study("case.toml", {"time.step": [0.1, 0.05]}, ["steps"], set=quick, workers=0)
    >>> found.to_pandas()["steps"].tolist()
    [2.0, 4.0]
    """
    case = base if isinstance(base, Case) else load_case(base)
    progress = more.pop("progress", None)
    tables = [
        {"key": key, **(plain(value) if isinstance(value, Mapping) else {"values": plain(value)})}
        for key, value in variables.items()
    ]
    data = {"variable": tables, "collect": plain(collect), **plain(more)}
    if not isinstance(base, Case):
        data["base"] = str(Path(base).resolve())
    spec = study_of(data, Path("study"))
    temporary = tempfile.TemporaryDirectory(prefix="contiga-study-") if out is None else None
    folder = Path(temporary.name if temporary is not None else out or ".")
    how: dict[str, Any] = {"scheduler": scheduler, "workers": workers, "resume": resume}
    return replace(run_study(spec, folder, base=case, progress=progress, **how), kept=temporary)


def run_study(
    study: StudySpec,
    out: Path,
    *,
    base: Case | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Study:
    """Run a study into its folder, cases, table, page and map, and return its results.

    With `resume`, cases that have a row in the folder are not run again. The table is written even
    if the study is interrupted, the page only at its end.

    Parameters
    ----------
    study : the specification
    out : folder of the study
    base : the base case, where it is not the file that the study names
    scheduler, workers : as `engines.engine_for`; if both are omitted, a process for each case, up
        to the number of cores
    resume : run what is missing in `out`
    progress : called with the finished cases, the number of all cases, and a message

    Raises
    ------
    InputError, MissingPackageError
        The study, its base case or the folder cannot be used; nothing has been run.
    RunError
        The cluster was lost; the rows so far are in the folder.
    """
    require("the table of a study", "h5py")
    require_packages("the page of a study")
    if study.goal is not None:
        require("an optimisation", "optuna")
    if base is None:
        assert study.base is not None
        base = load_case(study.base)
    # The text of a file is used as it is, because settings use its keys.
    text = resolved_toml(base)
    if study.base is not None:
        text = Path(study.base).read_text(encoding="utf-8-sig")
    common = Base(text, str(base.file.resolve()), str(out.resolve()), study.quantities)
    if study.goal is None:
        cases = cases_of(study, _targets(study, common), common.tables)
    else:
        cases = _cases_at_ends(study)
    _check(study, common, cases)
    folder = StudyFolder(out, study, common, base)
    folder.check(resume=resume)
    done: list[Row] = []
    if resume and study.goal is None:  # an optimiser finds them as it suggests cases
        done = [row for case in cases if (row := row_of(common, case)) is not None]
    numbers = {row.number for row in done}
    missing = [case for case in cases if case.number not in numbers]
    total = len(cases) if study.goal is None else study.goal.trials
    if workers is None and scheduler is None:
        workers = min(cores(), len(missing) if study.goal is None else study.goal.batch)
    with engine_for(common, scheduler=scheduler, workers=workers, retries=study.retries) as engine:
        folder.open(done)
        try:
            if progress is not None:
                progress(len(done), total, _failures_in_words(done))
            rows_to_come: Iterator[Row] = iter(())
            if study.goal is not None:
                rows_to_come = optimised(study, engine, folder)
            elif missing:
                rows_to_come = engine.run(missing)
            for row in rows_to_come:
                folder.take(row)
                if progress is not None:
                    progress(len(folder.rows), total, _failures_in_words(folder.rows.values()))
        finally:
            folder.write_table()
    rows = tuple(folder.rows[number] for number in sorted(folder.rows))
    best = None if study.goal is None else best_of(study.goal, rows)
    results = Study(folder.path, folder.table(), rows, best)
    write_page(study, folder.base, results.table, rows)
    return results


def _targets(study: StudySpec, base: Base) -> list[dict[str, Any]] | None:
    """Return the targets on a body of the base case with the common settings; None without any.

    A CaseError is raised if the base case does not have the body (`targets_of` has others).
    """
    if study.targets is None:
        return None
    case = base.case(study.set)
    simulation, name = build(case, parts=parts_of_process()), study.targets.body
    _check_body(study, "targets", name, list(simulation.bodies))
    body, pose = simulation.bodies[name].body, simulation.origins[simulation.mechanism.index[name]]
    with errors_at("", str(study.file)):
        return targets_of(study.targets, body, pose, case.units.length)


def _check_body(study: StudySpec, key: str, name: str, bodies: list[str]) -> None:
    """Refuse a body that the base case does not have."""
    if name not in bodies:
        raise CaseError(
            "the base case has no such body",
            where=f"{study.file}: {key}.body",
            found=name,
            allowed=", ".join(bodies),
            remedy=closest(name, bodies),
        )


def _failures_in_words(rows: Iterable[Row]) -> str:
    failed = sum(row.status != DONE for row in rows)
    return f"{failed} failed" if failed else ""


def _cases_at_ends(study: StudySpec) -> list[StudyCase]:
    """Return cases that an optimiser might suggest: all first values, then one changed at a time.

    The values of a variable are its ends, or the listed ones.
    """
    values_by_label = {
        variable.label: [variable.low, variable.high]
        if variable.ranged
        else listed_values(variable)
        for variable in study.variable
    }
    first = {label: values[0] for label, values in values_by_label.items()}
    variants = [
        first | {label: value} for label, values in values_by_label.items() for value in values[1:]
    ]
    return [case_of(study, number, values) for number, values in enumerate([first, *variants], 1)]


def _check(study: StudySpec, base: Base, cases: list[StudyCase]) -> None:
    """Raise the first CaseError of the study's keys, quantities, map or cases before any is run.

    The first case is checked, and of the others those with a value that no case before them has,
    up to `_MAX_CHECKED`.
    """
    check_keys(study, base.tables, cases[0].settings)
    first = base.case(cases[0].settings)
    columns, criteria = columns_of_case(first), criteria_of_case(first)
    for quantity in base.quantities.values():
        quantity.check(columns, criteria, first.time.end)
    if study.map is not None:
        _check_body(study, "map", study.map.body, [body.name for body in first.body])
    checked: set[tuple[str, str]] = set()
    n_checked = 0
    for case in cases[1:]:
        new = {(label, repr(value)) for label, value in case.values.items()} - checked
        if new and n_checked < _MAX_CHECKED:
            base.case(case.settings)
            n_checked += 1
        checked |= new
