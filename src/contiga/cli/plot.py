"""``contiga plot DIR``: curves of one run or several as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def plot(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR…", help="Output folders of runs or of a study.")
    ],
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="x.png|x.svg", help="Picture to write.")
    ],
    y: Annotated[
        list[str] | None,
        typer.Option(
            "-y",
            metavar="CHANNEL",
            help="Channel to draw, once for each; the curves of the report if left out.",
        ),
    ] = None,
    x: Annotated[
        str | None,
        typer.Option("-x", metavar="CHANNEL", help="Channel of the abscissa; time if left out."),
    ] = None,
) -> None:
    """Draw channels of runs over time or over each other, with the tests that the case names."""
    from contiga.cli.compare import runs_in
    from contiga.errors import InputError
    from contiga.report.curve_picture import draw_curves

    if x is not None and not y:
        raise InputError("is missing: what is to be drawn over x", where="-y", allowed="a channel")
    runs = [run for folder in folders for run in runs_in(folder)]
    if not runs:
        raise InputError("the study has no case that has run", where=str(folders[0]))
    draw_curves(runs, out, x=x, y=y or ())
    print(f"picture: {out}")
