"""`contiga verify`: closed forms against what runs give."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from contiga.cli.compiling import watch_compiling
from contiga.cli.options import Quiet
from contiga.errors import RunError
from contiga.running.progress import progress_bar


def verify(
    context: typer.Context,
    out: Annotated[Path, typer.Option("-o", "--out", metavar="DIR", help="Output folder.")] = Path(
        "verification"
    ),
    only: Annotated[
        str | None,
        typer.Option(
            "--only",
            metavar="spring,mass,…",
            help="Cases, or the first words of their names, separated by commas; all if left out.",
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Check motion, forces and criteria against closed forms: a page and its numbers."""
    from contiga_validation.verify import broken_cases
    from contiga_validation.verify import verify as run_all

    watch_compiling(context, helped=True)
    names = None if only is None else only.split(",")
    with progress_bar("verify", quiet=quiet) as show:
        page = run_all(out, only=names, progress=show)
    broken = broken_cases(out)
    if not quiet:
        print(f"report: {page}")
    if broken:
        raise RunError("not every case holds: " + "; ".join(broken))
