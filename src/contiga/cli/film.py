"""``contiga film DIR``: the recorded steps of a run as a film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from contiga.cli.options import Quiet
from contiga.running.progress import progress_bar


def film(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Output folder of a run.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Film to write, .mp4 or .gif; DIR/film.mp4 if left out."),
    ] = None,
    seconds: Annotated[
        float, typer.Option("--seconds", metavar="S", help="Length of the film, seconds.")
    ] = 6.0,
    quiet: Quiet = False,
) -> None:
    """Draw a film of the scene over time: .mp4, or .gif, which needs no encoder."""
    from contiga.report.film import write_film

    with progress_bar("film", quiet=quiet) as show:
        path = write_film(folder, out or folder / "film.mp4", seconds=seconds, show=show)
    if not quiet:
        print(f"film: {path}")
