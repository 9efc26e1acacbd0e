"""``contiga pack DIR``: a run or a study as one file to send."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def pack(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Output folder of a run or a study.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", metavar="x.zip", help="File to write; DIR.zip if left out."),
    ] = None,
    fields: Annotated[
        bool, typer.Option("--fields", help="Include the fields for ParaView, too.")
    ] = False,
) -> None:
    """Put the pages and numbers of a run or a study into one zip file for reading offline."""
    from contiga.report.pack import pack as write_zip

    resolved = folder.resolve()
    path = out if out is not None else resolved.with_name(f"{resolved.name}.zip")
    count = write_zip(folder, path, fields=fields)
    print(f"{path}: {count} files, {path.stat().st_size / 1e6:.3g} MB")
