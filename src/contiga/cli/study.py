"""``contiga study STUDY.toml``: many cases, one page of answers."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from contiga.cli.options import Quiet
from contiga.running.progress import progress_bar

if TYPE_CHECKING:
    from contiga.studies.study import Study

_MAX_PRINTED = 5
"""Largest number of failed cases whose messages are printed."""


def study(
    file: Annotated[Path, typer.Argument(metavar="STUDY.toml", help="The study file.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder; STUDY_out beside the file if left out."),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            "--scheduler",
            metavar="ADDRESS",
            help="A Dask scheduler that runs already; workers of this machine if left out.",
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            "--workers",
            metavar="N",
            help="Processes of this machine, one a core if left out; 0: one case after the other.",
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Run what is missing in the folder.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Run many cases of one base case: a table, a page, and the report of each."""
    from contiga.studies.spec import load_study
    from contiga.studies.study import run_study

    loaded = load_study(file)
    folder = out if out is not None else file.parent / f"{file.stem}_out"
    try:
        with progress_bar(loaded.title, quiet=quiet) as show:
            done = run_study(
                loaded, folder, scheduler=scheduler, workers=workers, resume=resume, progress=show
            )
    except KeyboardInterrupt:
        where = [] if scheduler is None else ["--scheduler", scheduler]
        line = shlex.join(["contiga", "study", str(file), "-o", str(folder), *where, "--resume"])
        print(f"\ncontiga: stopped; {line} runs what is missing", file=sys.stderr)
        raise
    if not quiet:
        _print(done)


def _print(done: Study) -> None:
    from contiga.report.style import number

    print(f"{len(done.rows)} cases, {len(done.failed)} failed")
    for row in done.failed[:_MAX_PRINTED]:
        print(f"case {row.number}: {row.message.splitlines()[0]}")
    if len(done.failed) > _MAX_PRINTED:
        print(f"and {len(done.failed) - _MAX_PRINTED} more")
    if done.best is not None:
        best = {**done.best.values, **done.best.collected}
        said = ", ".join(
            f"{name} {number(value) if isinstance(value, int | float) else value}"
            for name, value in best.items()
        )
        print(f"best is case {done.best.number}: {said}")
    print(f"page: {done.page}")
