"""``contiga study STUDY.toml``: many cases, one page of answers."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from contiga.cli.options import Quiet
from contiga.running.progress import progress_bar

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
            result = run_study(
                loaded, folder, scheduler=scheduler, workers=workers, resume=resume, progress=show
            )
    except KeyboardInterrupt:
        option = [] if scheduler is None else ["--scheduler", scheduler]
        line = shlex.join(["contiga", "study", str(file), "-o", str(folder), *option, "--resume"])
        print(f"\ncontiga: stopped; {line} runs what is missing", file=sys.stderr)
        raise
    if quiet:
        return
    from contiga.report.style import number

    print(f"{len(result.rows)} cases, {len(result.failed)} failed")
    for row in result.failed[:_MAX_PRINTED]:
        print(f"case {row.number}: {row.message.splitlines()[0]}")
    if len(result.failed) > _MAX_PRINTED:
        print(f"and {len(result.failed) - _MAX_PRINTED} more")
    if result.best is not None:
        values = ", ".join(
            f"{name} {number(value) if isinstance(value, int | float) else value}"
            for name, value in {**result.best.values, **result.best.collected}.items()
        )
        print(f"best is case {result.best.number}: {values}")
    print(f"page: {result.page}")
