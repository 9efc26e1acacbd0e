"""Running a case with everything that belongs to it: the run, its files, the report."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from contiga.case.schema import Case
    from contiga.sim.run import Result


def run(
    case: Case | str | Path,
    out: str | Path | None = None,
    *,
    resume: bool = False,
    quiet: bool = True,
) -> Result:
    """Run a case and write its output folder, the report included.

    Parameters
    ----------
    case : a `Case`, or the path of its file
    out : folder for the results; None keeps them in memory only
    resume : go on from the checkpoint in `out`
    quiet : no progress bar

    Returns
    -------
    Result
        ``history`` (columns by name), ``summary``, ``out``.

    Raises
    ------
    InputError
        Something in the case, its files or the folder is wrong; nothing has been written.
    RunError
        The run could not be carried through.
    """
    from contiga.case import build
    from contiga.case.schema import load_case
    from contiga.report import write_report

    checked = load_case(case) if isinstance(case, str | Path) else case
    with _bar(checked.title, quiet=quiet) as progress:
        return build.run(checked, out, resume=resume, progress=progress, on_finish=write_report)


@contextmanager
def _bar(title: str, *, quiet: bool) -> Iterator[Callable[[int, int, int], None] | None]:
    """A progress bar on the error stream: steps done, points in contact, time left."""
    if quiet:
        yield None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[contacts]} in contact"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(title, total=None, contacts=0)

        def progress(done: int, steps: int, contacts: int) -> None:
            bar.update(task, completed=done, total=steps, contacts=contacts)

        yield progress
