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
            help="What is drawn, such as head_cg.a; as in the report if left out. Repeatable.",
        ),
    ] = None,
    x: Annotated[
        str | None, typer.Option("-x", metavar="CHANNEL", help="Over what; time if left out.")
    ] = None,
) -> None:
    """Draw channels of runs over time or over each other, with the tests that the case names."""
    from contiga.errors import InputError
    from contiga.report.curve_picture import draw_curves

    if x is not None and not y:
        raise InputError("is missing: what is to be drawn over x", where="-y", allowed="a channel")
    draw_curves(folders, out, x=x, y=y or ())
    print(f"picture: {out}")
