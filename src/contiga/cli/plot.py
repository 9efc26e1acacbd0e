"""``contiga plot DIR``: curves of one run or several as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def plot(
    folders: Annotated[
        list[Path], typer.Argument(metavar="DIR…", help="Output folders of runs, drawn together.")
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
    from contiga.errors import InputError
    from contiga.report.curve_picture import draw_curves

    if x is not None and not y:
        raise InputError(
            "is missing, and -x needs a channel to draw over it", where="-y", allowed="a channel"
        )
    draw_curves(folders, out, x=x, y=y or ())
    print(f"picture: {out}")
